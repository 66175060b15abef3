"""A process for each simulator, with the packages of its own virtual environment."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

_HERE = Path(__file__).resolve().parent
_ENVIRONMENTS = _HERE.parents[1] / "build" / "peers"


class Simulator(NamedTuple):
    """A simulator, as it is measured."""

    name: str
    rooms: str
    """The module that opens its rooms."""
    most_robots: int
    """The largest number of robots in one room that is measured."""
    has_batches: bool = False
    variant: str = ""
    """The variant for the module's `open_room`."""
    requirement: str = ""
    """The requirements for pip; empty for Flatland, which this Python has."""
    flags: str = ""
    """Compiler flags for a build by pip."""


class PeerError(Exception):
    """A simulator cannot be installed, or its process has ended."""


def python_of(simulator: Simulator) -> str:
    """The interpreter for a simulator. Makes a peer's environment if it is not there yet.

    Raises:
        PeerError: pip cannot install it.
    """
    if not simulator.requirement:
        return sys.executable
    requirement, *others = simulator.requirement.split()
    folder = _ENVIRONMENTS / requirement.replace("==", "-")
    python, done = folder / "bin" / "python", folder / "installed"
    if not done.exists():
        print(f"installing {requirement} into {folder} ...", file=sys.stderr)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        for command in (
            [sys.executable, "-m", "venv", "--clear", str(folder)],
            [*pip, "--no-cache-dir", requirement, *others],  # a cached wheel may have other flags
        ):
            result = subprocess.run(
                command,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                env={**os.environ, "CFLAGS": simulator.flags, "CXXFLAGS": simulator.flags},
            )
            if result.returncode:
                raise PeerError(f"{requirement} cannot be installed:\n{result.stdout[-2000:]}")
        done.touch()
    return str(python)


class Process:
    """A process that measures a simulator; see worker.py.

    Args:
        simulator: the simulator to measure.

    Raises:
        PeerError: it cannot be installed, or does not start.
    """

    def __init__(self, simulator: Simulator) -> None:
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        environment["MPLBACKEND"] = "Agg"
        if simulator.requirement:
            environment.pop("PYTHONPATH", None)
        self._name = simulator.name
        self._folder = tempfile.TemporaryDirectory(prefix="flatland_peers_")
        environment["TMPDIR"] = self._folder.name  # for world files, deleted with the folder
        self._errors = (Path(self._folder.name) / "errors").open("w+")
        self._popen = subprocess.Popen(
            [python_of(simulator), str(_HERE / "worker.py"), simulator.rooms],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=environment,
            text=True,
        )

    def ask(self, **request: Any) -> Any:
        """Sends a request, and returns the answer.

        Raises:
            PeerError: the process has ended instead.
        """
        assert self._popen.stdin is not None
        assert self._popen.stdout is not None
        try:
            self._popen.stdin.write(json.dumps(request) + "\n")
            self._popen.stdin.flush()
            line = self._popen.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            self._popen.wait()
            self._errors.seek(0)
            raise PeerError(f"{self._name} has ended:\n{self._errors.read()[-2000:]}")
        return json.loads(line)

    def end(self) -> None:
        """Ends it."""
        self._popen.kill()
        self._popen.communicate()
        self._errors.close()
        self._folder.cleanup()
