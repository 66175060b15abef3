"""The C++ tests of the core (test/core): built and run, plain and with the sanitizers."""

import os
from pathlib import Path

import pytest
from commands import run

BUILD = Path(__file__).resolve().parents[3] / "build"
PROGRAMS = ("flatland_core_test", "flatland_core_test_sanitized")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def programs():
    """Builds the programs; returns their folder. Tests that run meanwhile have priority."""
    jobs = f"--parallel={os.cpu_count()}"
    run("nice", "cmake", "--build", BUILD, jobs, "--target", *PROGRAMS, timeout=None)
    return BUILD / "src" / "flatland_server" / "test" / "core"


@pytest.mark.parametrize("program", PROGRAMS)
def test_core(programs, program):
    """As the server uses it, and with AddressSanitizer and UndefinedBehaviorSanitizer."""
    run(programs / program, timeout=None)
