"""The extension refuses a NumPy whose arrays its pybind11 would make wrongly."""

import importlib.util
import sys
from types import SimpleNamespace

import pytest

from flatland_server import _core


def load(monkeypatch, numpy_version):
    """Loads the extension a second time, with another NumPy."""
    monkeypatch.setitem(sys.modules, "numpy", SimpleNamespace(__version__=numpy_version))
    spec = importlib.util.spec_from_file_location("_core", _core.__file__)
    importlib.util.module_from_spec(spec)


def test_numpy_2_is_refused_with_debians_pybind11(monkeypatch):
    with pytest.raises(ImportError, match=r"expected NumPy 1, found NumPy 2\.1\.0: .*pybind11 2"):
        load(monkeypatch, "2.1.0")
