"""With a NumPy that it was not built for, the core is not imported: its scans would be wrong."""

import subprocess
import sys

import pytest

from flatland_server import _core

IMPORT = """
import numpy
numpy.__version__ = "2.4.6"
import flatland_server
"""


def test_a_core_that_does_not_support_numpy_2_says_so():
    if _core.supports_numpy_2:
        pytest.skip("built with a pybind11 that supports it")
    done = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True)
    assert done.returncode == 1
    assert "supports NumPy before 2, found NumPy 2.4.6" in done.stderr
    assert "use /usr/bin/python3, or a terminal without setup.bash" in done.stderr
