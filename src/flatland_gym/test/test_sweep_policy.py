"""A policy that drives the robot of `flatland sweep`, as it does in its own environment."""

import json

import pytest

from flatland2d import YamlError
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import scenarios_of
from flatland_gym import SCENARIOS

POLICY = "package://flatland_gym/policies/discs.npz"


def results(folder, **keys):
    content = {
        "worlds": [str(SCENARIOS["discs"].world)],
        "controllers": [{"name": "trained", "policy": POLICY}],
        "start": "random",
        "goal": "random",
        **keys,
    }
    path = folder / "scenarios.yaml"
    path.write_text(json.dumps(content))
    settings = read_scenario_file(path)
    runner = ScenarioRunner(settings)
    return [runner.run(each) for each in scenarios_of(settings)]


@pytest.mark.slow
def test_it_reaches_its_goals(tmp_path):
    found = results(tmp_path, seeds=20, step_size=0.05, goal_distance=[2, 6])

    assert [result.error for result in found] == [""] * 20
    assert sum(result.row["success"] for result in found) >= 17


def test_a_robot_that_does_not_fit_is_told(tmp_path):
    parameters = {"models.robot.plugins.laser.angle.increment": 0.2}
    [result] = results(tmp_path, parameters=parameters)

    assert "one lidar of 64 beams, found 32" in result.error


def test_without_a_goal_there_is_no_run(tmp_path):
    with pytest.raises(YamlError, match='goal in world "discs", to which the controller "trained'):
        results(tmp_path, goal=None)


def test_another_file_is_no_policy(tmp_path):
    (tmp_path / "other.npz").write_text("")

    [result] = results(tmp_path, controllers=[{"name": "a", "policy": "other.npz"}])

    assert "expected a file of a policy" in result.error
