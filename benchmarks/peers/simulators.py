"""Simulators, and the virtual environments that their packages are installed into."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, Mapping, NamedTuple

_ENVIRONMENTS = Path(__file__).resolve().parents[2] / "build" / "peers"


class Simulator(NamedTuple):
    """A simulator, as it is measured."""

    name: str
    module: str
    """The module with its `Room` and `Batch`."""
    most_robots: int
    """The largest number of robots in one room that is measured."""
    has_batches: bool = False
    options: Mapping[str, Any] = {}
    """Further arguments of the module's `Room` and `Batch`."""
    requirement: str = ""
    """The requirements for pip; empty for Flatland, which this Python has."""
    flags: str = ""
    """Compiler flags for a build by pip."""


FLATLAND = Simulator("Flatland", "flatland_rooms", 1000, has_batches=True)
IRSIM = Simulator("ir-sim 2.12.0", "irsim_rooms", 100, requirement="ir-sim[all]==2.12.0")
SIMULATORS = (
    FLATLAND,
    FLATLAND._replace(name="Flatland, 20 x 5 ms", options={"substeps": 20}),
    IRSIM,
    IRSIM._replace(name="ir-sim, contact", options={"collisions": "contact"}),
    Simulator(
        "irsim-x 1.1.4",
        "irsim_rooms",
        1000,
        has_batches=True,
        requirement="irsim-x==1.1.4",
        flags="-mno-avx512f",  # with AVX-512, its batch leaves every other eight ranges undefined
    ),
    Simulator(
        "JalanSim 0.0.1",
        "jalansim_rooms",
        1,
        has_batches=True,
        requirement="jalansim==0.0.1 numpy",  # which it does not require itself
    ),
    Simulator(
        "JaxNav (jaxmarl 0.2.0)",
        "jaxnav_rooms",
        10,  # memory grows with the square of their number
        has_batches=True,
        requirement="jaxmarl==0.2.0",
    ),
)


class PeerError(Exception):
    """A simulator cannot be installed, or its measurement has failed."""


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
