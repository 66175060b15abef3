"""Every package's rostests (src/*/test/*.test), each against a ROS master of its own."""

import shutil
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[2]
ROSTESTS = sorted(SRC.glob("*/test/*.test"))
TIME_LIMIT = 120.0  # s

pytestmark = pytest.mark.slow


def run_rostest(path, results):
    """Run a rostest, with XML into `results`; return its exit code (None: out of time), output."""
    process = subprocess.Popen(
        [sys.executable, shutil.which("rostest"), f"--results-base-dir={results}", str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        output, _ = process.communicate(timeout=TIME_LIMIT)
        return process.returncode, output
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)  # it ends its nodes, which are in sessions of their own
        try:
            output, _ = process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            process.kill()
            output, _ = process.communicate()
        return None, output


def count(results):
    """Return how many tests, failures and errors there are in the results of a rostest's tests."""
    totals = dict.fromkeys(("tests", "failures", "errors"), 0)
    for file in results.glob("*/rosunit-*.xml"):
        try:
            suites = list(ElementTree.parse(file).getroot().iter("testsuite"))
        except ElementTree.ParseError:  # left by a test that was killed
            totals["errors"] += 1
            continue
        for suite in suites:
            for name in totals:
                totals[name] += int(suite.get(name, 0))
    return totals


@pytest.fixture
def results():
    """A folder for results, always below /tmp: rostest splits its path at spaces."""
    with tempfile.TemporaryDirectory(dir="/tmp", prefix="rostest_") as folder:
        yield Path(folder)


@pytest.mark.parametrize(
    "path", [pytest.param(path, id=f"{path.parts[-3]}/{path.stem}") for path in ROSTESTS]
)
def test_rostest(path, results):
    code, output = run_rostest(path, results)

    # The exit code alone says little: a rostest without a single test ends with 0.
    totals = count(results)
    if code != 0 or not totals["tests"] or totals["failures"] or totals["errors"]:
        ended = f"no end after {TIME_LIMIT:g} s" if code is None else f"exit code {code}"
        pytest.fail(f"{ended}, {totals}\n{output}", pytrace=False)
