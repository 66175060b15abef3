"""A virtual environment without ROS in which pip has installed the library from this clone.

The wheel is built in each run of the tests, from what is left of the last build in build/test/pip,
so that only what has changed is compiled. The environment has the packages of PyPI that the wheel
asks for, and keeps them for the next run.
"""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from email.parser import BytesParser
from pathlib import Path

import pytest
from commands import run
from without_ros import BLOCK_ROS

ROOT = Path(__file__).resolve().parents[4]
FOLDER = ROOT / "build" / "test" / "pip"

# Packages to build the wheel and the example package. pip would install them again for each
# build, in another place, and everything would be compiled again.
BUILD_REQUIREMENTS = (
    "scikit-build-core==0.11.6",
    "pybind11==2.13.6",
    "setuptools==75.3.2",
    "wheel==0.45.1",
    "catkin_pkg==1.0.0",
)

FLATLAND = """#!/usr/bin/env python3
import sys
from flatland2d.cli import main
sys.exit(main())
"""


def environment():
    """This process's environment, without variables of ROS and Python and without search paths."""
    ros = ("ROS", "PYTHON", "SETUPTOOLS", "CMAKE_PREFIX_PATH", "PKG_CONFIG_PATH", "LD_LIBRARY_PATH")
    return {name: value for name, value in os.environ.items() if not name.startswith(ros)}


class Environment:
    """A virtual environment, which has the packages of these requirements."""

    def __init__(self, name, requirements):
        key = hashlib.sha256("\n".join([sys.version, *requirements]).encode()).hexdigest()[:16]
        self.folder = FOLDER / f"{name}-{key}"
        self.python = self.folder / "bin" / "python"
        if not (self.folder / "complete").exists():
            for former in FOLDER.glob(f"{name}-*"):
                shutil.rmtree(former)
            self._run(sys.executable, "-m", "venv", self.folder)
            self.pip("install", *requirements)
            (self.folder / "complete").touch()

    def pip(self, command, *arguments):
        self.run("-m", "pip", "--disable-pip-version-check", command, "-q", *arguments)

    def run(self, *arguments, **variables):
        """The output of its Python."""
        return self._run(self.python, *arguments, **variables)

    def start(self, *arguments, **variables):
        """A process of its Python."""
        return subprocess.Popen(
            [self.python, *arguments],
            stdout=subprocess.PIPE,
            text=True,
            env={**environment(), **variables},
        )

    def command(self, name, *arguments, **variables):
        """The output of a command that a package has installed."""
        return self._run(self.folder / "bin" / name, *arguments, **variables)

    @staticmethod
    def _run(*command, **variables):
        variables = {name: str(value) for name, value in variables.items()}
        return run(*command, cwd=FOLDER, env={**environment(), **variables})

    def wheel(self, folder, build, *settings):
        """Builds the wheel of the clone.

        Args:
            folder: folder to write the wheel to.
            build: name of a folder for what is compiled, which stays for the next time.
            settings: settings of scikit-build-core, such as "cmake.define.NAME=VALUE".
        """
        settings = (f"build-dir={FOLDER / build}", *settings)
        self.pip(
            "wheel",
            "--no-build-isolation",
            "--no-deps",
            f"--wheel-dir={folder}",
            *(f"--config-settings={setting}" for setting in settings),
            ROOT,
        )
        [wheel] = folder.glob("*.whl")
        return wheel


@pytest.fixture(scope="session")
def builder():
    """An environment with the tools that build wheels."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    return Environment("builder", BUILD_REQUIREMENTS)


@pytest.fixture(scope="session")
def wheel(builder, tmp_path_factory):
    """The wheel of the clone."""
    return builder.wheel(tmp_path_factory.mktemp("wheel"), "build")


@pytest.fixture(scope="session")
def library(wheel):
    """An environment in which the wheel is installed."""
    return with_wheel("library", wheel)


@pytest.fixture(scope="session")
def library_with_ray(wheel):
    """The same with Ray and pyarrow, half a gigabyte; skips where they cannot be installed."""
    try:
        return with_wheel("ray", wheel, "ray==2.60.0", "pyarrow==26.0.1")
    except pytest.fail.Exception as error:
        pytest.skip(f"Ray cannot be installed: {error}")


@pytest.fixture(scope="session")
def library_with_sb3(wheel):
    """The same with the extra `sb3` and torch for CPUs; skips where it cannot be installed."""
    torch = ("--extra-index-url=https://download.pytorch.org/whl/cpu", "torch==2.13.0+cpu")
    try:
        return with_wheel("sb3", wheel, *torch, "pytest==9.0.2", extra="sb3")
    except pytest.fail.Exception as error:
        pytest.skip(f"Stable-Baselines3 cannot be installed: {error}")


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
            **environment(),
            "HOME": str(folder),
            "PATH": f"{command.parent}:{os.environ['PATH']}",
            "PYTHONPATH": os.pathsep.join([str(folder), *of_tests]),
        },
    )


def with_wheel(name, wheel, *more, extra=""):
    """An environment with a wheel, its requirements and those of an extra, and more."""
    with zipfile.ZipFile(wheel) as archive:
        [metadata] = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        required = BytesParser().parsebytes(archive.read(metadata)).get_all("Requires-Dist")
    marker = re.compile(rf"""extra == ['"]{extra}['"]""")
    required = [each for each in required if "extra ==" not in each or marker.search(each)]
    required = [each.partition(";")[0] for each in required]
    library = Environment(name, [*required, *more])
    library.pip("install", "--no-deps", "--no-index", "--force-reinstall", wheel)
    return library
