"""Readers of docs/ who have the library by pip, and environments in which it is installed."""

import os
import sys
import zipfile

import pip_environments
import pytest
from commands import run
from pip_environments import ROOT
from without_ros import BLOCK_ROS

FLATLAND = """#!/usr/bin/env python3
import sys
from flatland2d.cli import main
sys.exit(main())
"""


@pytest.fixture(scope="session")
def builder():
    """An environment with the tools that build wheels."""
    return pip_environments.builder()


@pytest.fixture(scope="session")
def wheel():
    """The wheel of the clone."""
    return pip_environments.wheel()


@pytest.fixture(scope="session")
def library():
    """An environment in which the wheel is installed."""
    return pip_environments.library()


class Reader:
    """A Python with the wheel, in which ROS is blocked, for a reader who has the library by pip.

    It has the tests' packages from PyPI, which costs less than an environment with all extras.
    """

    def __init__(self, command, variables):
        self.command = command
        self._variables = variables

    def run(self, folder, *words):
        """Runs a Python program and returns its output; if it fails, so does the test."""
        return run(sys.executable, *words, cwd=folder, env=self._variables)


@pytest.fixture(scope="session")
def reader(wheel, tmp_path_factory):
    """A reader of the guide without ROS."""
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    (folder / "sitecustomize.py").write_text(BLOCK_ROS)  # each Python begins with it
    command = folder / "bin" / "flatland"
    command.parent.mkdir()
    command.write_text(FLATLAND)
    command.chmod(0o755)
    of_tests = [path for path in sys.path if path.startswith(f"{ROOT}/build/test/")]
    return Reader(
        command,
        {
            **pip_environments.environment(),
            "HOME": str(folder),
            "PATH": f"{command.parent}:{os.environ['PATH']}",
            "PYTHONPATH": os.pathsep.join([str(folder), *of_tests]),
        },
    )
