"""The C++ tests of the core (test/core): built and run, plain and with the sanitizers."""

import os
import subprocess
from pathlib import Path

import pytest

BUILD = Path(__file__).resolve().parents[3] / "build"
PROGRAMS = ("flatland_core_test", "flatland_core_test_sanitized")

pytestmark = pytest.mark.slow


def run(*command):
    """Run a command; if it fails, so does the test, with the command's output."""
    words = [str(word) for word in command]
    result = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        pytest.fail(
            f"{' '.join(words)}: exit code {result.returncode}\n{result.stdout}", pytrace=False
        )


@pytest.fixture(scope="module")
def programs():
    """Builds the programs; returns their folder. Tests that run meanwhile have priority."""
    jobs = f"--parallel={os.cpu_count()}"
    run("nice", "cmake", "--build", BUILD, jobs, "--target", *PROGRAMS)
    return BUILD / "src" / "flatland_server" / "test" / "core"


@pytest.mark.parametrize("program", PROGRAMS)
def test_core(programs, program):
    """As the server uses it, and with AddressSanitizer and UndefinedBehaviorSanitizer."""
    run(programs / program)
