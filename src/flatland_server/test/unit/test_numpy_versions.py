"""Errors of the core's import: a NumPy that it was not built for, and Ctrl-C."""

import subprocess
import sys

import pytest

from flatland_server import _core

IMPORT = """
import numpy
numpy.__version__ = "2.4.6"
import flatland_server
"""


INTERRUPT = """
import sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == "numpy":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupt())
import flatland_server
"""


def test_ctrl_c_while_the_core_is_loaded_is_no_wrong_python():
    done = subprocess.run([sys.executable, "-c", INTERRUPT], capture_output=True, text=True)
    assert done.stderr.splitlines()[-1] == "KeyboardInterrupt"


def test_a_core_that_does_not_support_numpy_2_says_so():
    if _core.supports_numpy_2:
        pytest.skip("built with a pybind11 that supports it")
    done = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True)
    assert done.returncode == 1
    assert "supports NumPy before 2, found NumPy 2.4.6" in done.stderr
    assert "use /usr/bin/python3, or a terminal without setup.bash" in done.stderr
