"""The C++ tests of the core (test/core): built and run, plain and with the sanitizers."""

import os
import subprocess
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent / "core"
BUILD = Path(__file__).resolve().parents[3] / "build"

pytestmark = pytest.mark.slow


def run(*command):
    """Run a command; if it fails, so does the test, with the command's output."""
    words = [str(word) for word in command]
    result = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        pytest.fail(
            f"{' '.join(words)}: exit code {result.returncode}\n{result.stdout}", pytrace=False
        )


def build(folder, *options):
    """Compile; the tests that run meanwhile, some of them in real time, come first."""
    run("nice", "cmake", "--build", folder, "--parallel", os.cpu_count(), *options)


def test_core_as_the_server_uses_it():
    """With the objects of the extension module; only the tests are compiled."""
    build(BUILD, "--target", "flatland_core_test")

    run(BUILD / "src" / "flatland_server" / "test" / "core" / "flatland_core_test")


def test_core_under_the_sanitizers():
    """With AddressSanitizer and UndefinedBehaviorSanitizer, the core and the tests."""
    folder = BUILD / "core_test_sanitized"

    run("cmake", "-S", SOURCE, "-B", folder, "-DFLATLAND_SANITIZE=ON")
    build(folder)

    run(folder / "flatland_core_test")
