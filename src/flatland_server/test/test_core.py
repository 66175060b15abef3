"""The C++ tests of the core (test/core): built, plain and with the sanitizers, and run."""

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


@pytest.mark.parametrize(
    ("folder", "options"),
    [
        pytest.param("core_test", [], id="plain"),
        pytest.param("core_test_sanitized", ["-DFLATLAND_SANITIZE=ON"], id="sanitized"),
    ],
)
def test_core(folder, options):
    build = BUILD / folder

    run("cmake", "-S", SOURCE, "-B", build, *options)
    run("cmake", "--build", build, "--parallel", os.cpu_count())

    run(build / "core_test")
