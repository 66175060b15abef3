"""The C++ tests of the core (test/core): built and run, plain and with the sanitizers."""

import fcntl
import os
from pathlib import Path

import pytest
from commands import run

BUILD = Path(__file__).resolve().parents[3] / "build"
PROGRAMS = ("flatland_core_test", "flatland_core_test_sanitized")

pytestmark = pytest.mark.slow


def build():
    """Builds the programs, in one process at a time; returns their folder."""
    with (BUILD / "core_test.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        jobs = f"--parallel={os.cpu_count()}"
        run("cmake", "--build", BUILD, jobs, "--target", *PROGRAMS, timeout=None)
    return BUILD / "src" / "flatland_server" / "test" / "core"


@pytest.mark.parametrize("program", PROGRAMS)
def test_core(program):
    """As the server uses it, and with AddressSanitizer and UndefinedBehaviorSanitizer."""
    run(build() / program, timeout=None)


if __name__ == "__main__":
    build()
