"""The library's wheel, and virtual environments without ROS in which pip has installed it.

They are kept in build/test/pip. The wheel is built when a source has changed: of a copy of the
sources, with a build folder that lies as catkin's does and catkin's options, so that ccache has
compiled the core before. An environment has the packages of PyPI that the wheel asks for.
"""

import contextlib
import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from email.parser import BytesParser
from pathlib import Path

from commands import run

ROOT = Path(__file__).resolve().parents[4]
FOLDER = ROOT / "build" / "test" / "pip"
SOURCE = FOLDER / "source"

BUILDER = "builder"
# Packages to build the wheel and the example package. pip would install them again for each
# build, in another place.
BUILD_REQUIREMENTS = (
    "scikit-build-core==0.11.6",
    "pybind11==2.13.6",
    "setuptools==75.3.2",
    "wheel==0.45.1",
    "catkin_pkg==1.0.0",
)
AS_CATKIN = ("FLATLAND_WERROR=ON", "CMAKE_CXX_FLAGS=-DROS_BUILD_SHARED_LIBS=1")
# Alone: where this index cannot be reached, pip would try for 8 s for each package, not once.
TORCH = ("--no-deps", "--extra-index-url=https://download.pytorch.org/whl/cpu", "torch==2.13.0+cpu")


def environment():
    """This process's environment, without variables of ROS and Python and without search paths."""
    ros = ("ROS", "PYTHON", "SETUPTOOLS", "CMAKE_PREFIX_PATH", "PKG_CONFIG_PATH", "LD_LIBRARY_PATH")
    return {name: value for name, value in os.environ.items() if not name.startswith(ros)}


class Environment:
    """A virtual environment, which has the packages of these requirements.

    Those of `first` are installed before the others. Only the builder has a pip, which installs
    into all: it takes 2 s to make another one.
    """

    def __init__(self, name, requirements, first=()):
        key = hashlib.sha256("\n".join([sys.version, *first, *requirements]).encode()).hexdigest()[
            :16
        ]
        self.folder = FOLDER / f"{name}-{key}"
        self.python = self.folder / "bin" / "python"
        self._complete = self.folder / "complete"
        with _one_at_a_time(name):
            if not self._complete.exists():
                for former in FOLDER.glob(f"{name}-*"):
                    shutil.rmtree(former)
                without_pip = [] if name == BUILDER else ["--without-pip"]
                self._run(sys.executable, "-m", "venv", *without_pip, self.folder)
                for each in filter(None, (first, requirements)):
                    self.pip("install", "--no-compile", *each)  # few modules are imported
                self._complete.touch()

    def pip(self, command, *arguments):
        """Runs the builder's pip for this environment."""
        its_own = self.folder.name.startswith(BUILDER)
        options = ("--disable-pip-version-check", "--python", self.python)
        (self if its_own else builder()).run("-m", "pip", *options, command, "-q", *arguments)

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

    def install_wheel(self, wheel):
        """Installs a wheel in place of another one, without what it requires."""
        with zipfile.ZipFile(wheel) as archive:
            key = str(sorted((each.filename, each.CRC) for each in archive.infolist()))
        with _one_at_a_time(self.folder.name.partition("-")[0]):
            if self._complete.read_text() != key:
                self.pip("install", "--no-deps", "--no-index", "--force-reinstall", wheel)
                self._complete.write_text(key)

    @staticmethod
    def _run(*command, **variables):
        variables = {name: str(value) for name, value in variables.items()}
        return run(*command, cwd=FOLDER, env={**environment(), **variables})

    def wheel(self, folder, source, *settings):
        """Builds a wheel.

        Args:
            folder: folder to write the wheel to.
            source: folder of the sources; its folder `build` stays for the next time.
            settings: settings of scikit-build-core, such as "cmake.define.NAME=VALUE".
        """
        settings = (f"build-dir={source / 'build'}", *settings)
        self.run(
            *("-m", "pip", "wheel", "-q", "--no-build-isolation", "--no-deps"),
            f"--wheel-dir={folder}",
            *(f"--config-settings={setting}" for setting in settings),
            source,
            **{"CMAKE_GENERATOR": "Unix Makefiles", "CC": "cc", "CXX": "c++"},  # as catkin's
        )
        [wheel] = folder.glob("*.whl")
        return wheel


@contextlib.contextmanager
def _one_at_a_time(name):
    """A context in which one process makes a thing of a name."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def builder():
    """An environment with the tools that build wheels."""
    return Environment(BUILDER, BUILD_REQUIREMENTS)


def copy_sources(folder):
    """Copies what the wheel is built of; what is unchanged keeps its time."""
    shutil.rmtree(folder / "src", ignore_errors=True)
    ignored = shutil.ignore_patterns("test", "__pycache__", "flatland_viz", "flatland_benchmark")
    shutil.copytree(ROOT / "src", folder / "src", ignore=ignored)
    for name in ("CHANGELOG.md", "CMakeLists.txt", "LICENSE", "README.md", "pyproject.toml"):
        shutil.copy2(ROOT / name, folder)


def wheel():
    """The wheel of the clone."""
    tools = builder()
    with _one_at_a_time("wheel"):
        copy_sources(SOURCE)
        key = hashlib.sha256(tools.folder.name.encode())
        for path in sorted([*SOURCE.glob("*"), *SOURCE.glob("src/**/*")]):
            key.update(f"{path}\n".encode() + (path.read_bytes() if path.is_file() else b""))
        folder = FOLDER / f"wheel-{key.hexdigest()[:16]}"
        if not folder.exists():
            for former in FOLDER.glob("wheel-*"):
                shutil.rmtree(former)
            (SOURCE / "wheel").mkdir(exist_ok=True)
            tools.wheel(SOURCE / "wheel", SOURCE, *(f"cmake.define.{each}" for each in AS_CATKIN))
            (SOURCE / "wheel").rename(folder)
        [wheel] = folder.glob("*.whl")
        return wheel


def with_wheel(name, *more, extra="", first=()):
    """An environment with the wheel, its requirements and those of an extra, and more."""
    built = wheel()
    with zipfile.ZipFile(built) as archive:
        [metadata] = [name for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
        required = BytesParser().parsebytes(archive.read(metadata)).get_all("Requires-Dist")
    marker = re.compile(rf"""extra == ['"]{extra}['"]""")
    required = [each for each in required if "extra ==" not in each or marker.search(each)]
    required = [each.partition(";")[0] for each in required]
    library = Environment(name, [*required, *more], first)
    library.install_wheel(built)
    return library


def library():
    """An environment in which the wheel is installed."""
    return with_wheel("library")


def with_ray():
    """The same with Ray and pyarrow, half a gigabyte."""
    return with_wheel("ray", "ray==2.60.0", "pyarrow==26.0.1")


def with_sb3():
    """The same with the extra `sb3` and torch for CPUs."""
    return with_wheel("sb3", "pytest==9.0.2", extra="sb3", first=TORCH)


if __name__ == "__main__":
    for make in sys.argv[1:]:
        globals()[make]()
