"""The examples of examples/: each loads, and does what its README says."""

import importlib.util
import math
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from flatland2d.sweep.fingerprints import Fingerprints
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import scenarios_of

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
EXAMPLES = sorted(path.parent.name for path in (ROOT / "examples").glob("*/README.md"))

spec = importlib.util.spec_from_file_location("example_run", ROOT / "scripts" / "example_run.py")
example_run = importlib.util.module_from_spec(spec)
spec.loader.exec_module(example_run)


@pytest.fixture
def start():
    """Starts an example in this process."""
    runs = []

    def start(*arguments):
        runs.append(example_run.ExampleRun(*arguments))
        return runs[-1]

    yield start
    for run in runs:
        run.close()


def step_until(run, holds, limit):
    """Steps until a condition holds; fails after a limit of simulated time [s]."""
    while not holds():
        assert run.simulation.time < limit, "it takes too long"
        run.step()


def test_each_folder_has_its_files_and_is_in_the_list():
    listed = re.findall(r"^\| \[(\w+)\]\(\1\)", (ROOT / "examples" / "README.md").read_text(), re.M)
    assert sorted(listed) == EXAMPLES
    for name in EXAMPLES:
        folder = ROOT / "examples" / name
        starts = [folder / f"{name}.launch", folder / "scenarios.yaml"]
        assert sum(path.is_file() for path in starts) == 1
        assert (folder / "picture.png").is_file()
        readme = (folder / "README.md").read_text()
        assert f"scripts/run examples/{name}" in readme
        assert "](picture.png)" in readme
    assert set(EXAMPLES) < set((ROOT / "examples" / "CMakeLists.txt").read_text().split())


def test_the_robot_of_the_tour_reaches_rooms(start):
    run = start("office_tour")
    step_until(run, lambda: run.drivers[0].reached >= 2, limit=90)


def test_the_tricycle_pulls_its_trailers_in_a_circle(start):
    run = start("tricycle_trailer")
    model = run.simulation.models["tricycle"].model
    first = model.bodies["trailer_2"].pose
    step_until(run, lambda: run.simulation.models["tricycle"].pose.y > 0.5, limit=20)
    last = model.bodies["trailer_2"].pose
    assert math.hypot(last.x - first.x, last.y - first.y) > 3.0


def test_doors_open_and_close(start):
    run = start("automatic_door")
    doors = [run.simulation.models[name] for name in ("west_door", "east_door")]
    step_until(run, lambda: doors[0].pose.y > 1.3, limit=20)
    step_until(run, lambda: doors[1].pose.y > 1.3, limit=40)
    step_until(run, lambda: run.drivers[0].reached >= 1, limit=40)
    step_until(run, lambda: all(door.pose.y < 0.01 for door in doors), limit=60)


def test_thirty_carriers_drive_and_touch_nothing(start):
    run = start("warehouse")
    carriers = run.simulation.models
    assert len(carriers) == 30
    places = {name: model.pose for name, model in carriers.items()}
    while run.simulation.time < 8.0:
        run.step()
        assert not run.simulation.contacts
    for name, model in carriers.items():
        assert math.dist(model.pose[:2], places[name][:2]) > 3.0


def test_the_car_laps_its_track_and_touches_nothing(start):
    run = start("racecar")
    [racer] = run.drivers
    while racer.laps < 1.0:
        assert run.simulation.time < 25.0, "it takes too long"
        run.step()
        assert not run.simulation.contacts


def test_the_robot_crosses_the_crowd(start):
    run = start("crowd")
    step_until(run, lambda: run.drivers[0].reached >= 1, limit=120)


def test_two_robots_navigate(start):
    run = start("navigation", "robots:=2")
    assert [driver.robot.name for driver in run.drivers] == ["r1", "r2"]
    step_until(run, lambda: run.drivers[1].reached >= 1, limit=60)


def test_the_sweep_compares_controllers():
    """All of them arrive."""
    settings = read_scenario_file(ROOT / "examples" / "sweep" / "scenarios.yaml")
    scenarios = scenarios_of(settings)
    fingerprints = Fingerprints(settings)
    assert len({fingerprints.of(scenario) for scenario in scenarios}) == 120
    runner = ScenarioRunner(settings)
    outcomes = {
        str(scenario): runner.run(scenario).row["outcome"]
        for scenario in scenarios
        if scenario.number in (1, 21, 31, 41, 61)
    }
    late = [name for name, outcome in outcomes.items() if outcome != "goal"]
    assert len(outcomes) == 5
    assert late == []


def test_the_mppi_example_reaches_its_goal(tmp_path):
    """One that is nearer than its own, which take a minute."""
    shutil.copytree(ROOT / "examples" / "mppi", tmp_path, dirs_exist_ok=True)
    scenarios = tmp_path / "scenarios.yaml"
    scenarios.write_text(scenarios.read_text().replace("[8, 15]", "[2, 3]"))
    settings = read_scenario_file(scenarios)
    row = ScenarioRunner(settings).run(scenarios_of(settings)[0]).row
    assert row["outcome"] == "goal"
    assert row["path_length"] < 1.3 * row["shortest_path"]


def test_a_folder_starts_its_sweep(tmp_path):
    """The options after the folder are the sweep's; a folder among them is not started."""
    result = subprocess.run(
        [ROOT / "scripts" / "run", ROOT / "examples" / "sweep", "--replay", "41", "--out", "."],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert result.returncode == 0, result.stdout
    assert "controller trained" in result.stdout
    assert "outcome: goal" in result.stdout


def test_a_folder_starts_its_launch_file(run):
    launch = run(str(ROOT / "examples" / "warehouse"), "show_viz:=false")
    launch.wait_for("running")
    launch.wait_until(lambda: "/fleet" in launch.nodes(), "the fleet")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["docs"], "expected one launch file in docs, or a scenarios.yaml"),
        (["examples/navigation", "robot:=2"], 'no argument "robot" (did you mean "robots"?)'),
    ],
)
def test_wrong_arguments_are_refused(arguments, expected):
    result = subprocess.run(
        [str(ROOT / "scripts" / "run"), *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert result.returncode != 0
    assert expected in result.stdout
