"""benchmark.launch with a world of the user's: it runs for some simulated time, and ends."""

import re
import shutil
import sys
from pathlib import Path

import pytest

SRC = Path(__file__).resolve().parents[2]
WORLD = SRC / "flatland_server" / "worlds" / "test_room" / "world.yaml"
SPEED = re.compile(
    r"simulated (\S+) s in (\S+) s of real time: (\S+) times real time; (\d+) steps of \S+ us"
)

pytestmark = pytest.mark.slow


@pytest.fixture
def benchmark(run, master):
    """Runs `roslaunch flatland_server benchmark.launch` to its end."""

    def start(*arguments):
        words = ("flatland_server", "benchmark.launch", *arguments)
        roslaunch = (sys.executable, shutil.which("roslaunch"))
        launch = run(*words, command=roslaunch, with_port=False, port=master.port)
        launch.process.wait(60)
        return launch.output

    return start


def test_a_world_runs_for_the_duration_and_reports_its_speed(benchmark):
    output = benchmark(f"world_path:={WORLD}", "benchmark_duration:=2", "step_size:=0.01")

    [(simulated, real, factor, steps)] = SPEED.findall(output)
    assert (float(simulated), int(steps)) == (2.0, 200)
    assert float(factor) == pytest.approx(2.0 / float(real), rel=1e-2)
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (("world:=1",), 'benchmark.launch has no argument "world"'),
        (
            (f"world_path:={WORLD}", "benchmark_duration:=-1"),
            "~benchmark_duration: expected a number above 0, found -1",
        ),
    ],
)
def test_wrong_arguments_end_it_with_an_error(benchmark, arguments, error):
    assert error in benchmark(*arguments)
