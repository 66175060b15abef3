"""Runs of scenarios in this process: metrics against geometry, controllers, errors."""

import math

import numpy as np
import pytest

from flatland2d import Pose, Simulation
from flatland2d.sweep.run import RunObserver
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import scenarios_of
from flatland_server import _core


def results_of(settings):
    runner = ScenarioRunner(settings)
    return [runner.run(each) for each in scenarios_of(settings)]


def edit_world(folder, old, new):
    text = (folder / "world.yaml").read_text()
    assert text.count(old) == 1
    (folder / "world.yaml").write_text(text.replace(old, new))


def controllers(name, **arguments):
    given = ", ".join(f"{key}: {value}" for key, value in arguments.items())
    return f'[{{name: a, call: "drivers.py:{name}", arguments: {{{given}}}}}]'


AHEAD = {"controllers": controllers("ahead"), "seeds": 1, "start": None}


def test_a_goal_ahead_is_reached_when_the_way_is_driven(settings_of):
    [result] = results_of(settings_of(**AHEAD, goal="[-1, 0]", goal_radius=0.25))

    row = result.row
    assert (row["outcome"], row["success"], row["collision"]) == ("goal", True, False)
    assert result.error == ""
    assert row["time_to_goal"] == row["time"] == pytest.approx(1.75 / 0.5, abs=0.006)
    assert row["path_length"] == pytest.approx(1.75, abs=0.003)
    assert row["goal_distance"] == pytest.approx(0.25, abs=0.003)
    assert row["min_clearance"] == pytest.approx(0.8)  # at the start, to the wall behind
    assert (row["start_x"], row["start_y"], row["goal_x"]) == (-3.0, 0.0, -1.0)
    assert (row["contacts"], row["speed_change"], row["turn_change"]) == (0, 0.0, 0.0)
    assert (row["localization_error"], row["max_localization_error"]) == (None, None)


def test_a_wall_ahead_ends_the_run_with_a_collision(settings_of):
    [result] = results_of(settings_of(**AHEAD, goal=None, time_limit=30))

    row = result.row
    assert (row["outcome"], row["success"], row["collision"]) == ("collision", None, True)
    assert row["time"] == pytest.approx(6.8 / 0.5, abs=0.06)
    assert row["min_clearance"] == 0.0


def test_times_are_those_of_whole_steps(settings_of):
    [result] = results_of(settings_of(**AHEAD, goal=None, time_limit=4.55))

    assert repr(result.row["time"]) == "4.55"


def test_contacts_commands_and_estimates_are_scored(settings_of):
    task = {**AHEAD, "controllers": controllers("knocks"), "goal": None}
    [result] = results_of(settings_of(**task, time_limit=15, collision_ends=False))

    row = result.row
    assert (row["outcome"], row["collision"], row["time"]) == ("returned", True, 4.5)
    assert (row["contacts"], row["collision_with"]) == (2, "walls")
    assert row["speed_change"] == pytest.approx(3.0)
    assert row["turn_change"] == pytest.approx(0.4)
    assert row["localization_error"] == pytest.approx(0.2)
    assert row["max_localization_error"] == pytest.approx(0.4)


@pytest.mark.parametrize("y", ["nan", "inf", "-1e300"])
def test_an_estimate_that_is_no_place_is_an_error(settings_of, y):
    task = {**AHEAD, "controllers": controllers("strays", y=y), "goal": None}
    [result] = results_of(settings_of(**task))

    assert "expected an estimate within 1e+09 m, found (" in result.error


def test_a_world_runs_by_itself(settings_of):
    task = {"controllers": None, "seeds": 1, "start": None, "goal": None}
    [result] = results_of(settings_of(**task, time_limit=0.5))

    assert (result.row["outcome"], result.row["path_length"]) == ("time limit", 0.0)


def test_starts_and_goals_are_drawn_from_the_seed_alone(settings_of):
    rows = [
        [result.row for result in results_of(settings_of(controllers=controllers(name), seeds=5))]
        for name in ("towards", "ahead")
    ]

    for first, second in zip(*rows):
        places = ("start_x", "start_y", "start_yaw", "goal_x", "goal_y")
        assert [first[name] for name in places] == [second[name] for name in places]
        way = (first["goal_x"] - first["start_x"], first["goal_y"] - first["start_y"])
        assert 1.0 <= math.hypot(*way) <= 3.0 + 1e-6
        assert max(abs(first[name]) for name in ("start_x", "start_y", "goal_x", "goal_y")) <= 3.7
    assert len({row["start_x"] for row in rows[0]}) == 5


@pytest.mark.parametrize("task", [{"start": None}, {"goal": "[1, -2]"}])
def test_one_of_start_and_goal_may_be_given(settings_of, task):
    for result in results_of(settings_of(**task)):
        row = result.row
        start, goal = (row["start_x"], row["start_y"]), (row["goal_x"], row["goal_y"])
        if "goal" in task:
            assert goal == (1.0, -2.0)
        else:
            assert start == (-3.0, 0.0)
        assert 1.0 <= math.dist(start, goal) <= 3.0 + 1e-6


def test_parameters_change_the_world_and_the_controller(folder, settings_of):
    edit_world(folder, "-3,", "'$eval param(\"/x\", -9)',")
    parameters = "{controller.speed: [0.5, 1], /x: -3, models.robot.pose.0: [-3, -2.5]}"

    results = results_of(settings_of(**AHEAD, goal="[-2, 0]", parameters=parameters))

    assert {result.error for result in results} == {""}
    rows = [result.row for result in results]
    assert [row["start_x"] for row in rows] == [-3.0, -2.5, -3.0, -2.5]
    assert [row["time"] for row in rows] == pytest.approx([1.4, 0.4, 0.7, 0.2], abs=0.011)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("return 1 / 0", "ZeroDivisionError: division by zero (mine.py:2)"),
        ("raise SystemExit(3)", "SystemExit: 3 (mine.py:2)"),
        ("return 5", "expected the controller to return None or a dict"),
        ("return {'a': object()}", "numbers, booleans and strings by name"),
        ("return {'success': 1}", "success as a boolean, found 'success': 1"),
        ("return {'time': 5}", 'returns "time", which is a column already'),
        ("return {'failed': 5}", 'returns "failed", which is a column already'),
        ("return {'x': 5, 'x_low': 4}", 'returns "x_low", which is a column already'),
        ("run.robot.command(1)", "UsageError: the drive"),
        ("run.step(0.003)", "to be a multiple of the step_size"),
        ("run.step(float('inf'))", "UsageError: expected the duration as a number of seconds"),
        ("yield run.step()", "expected drive to be a function that steps the run until it is over"),
    ],
)
def test_a_controller_that_fails_is_a_result_with_the_reason(folder, settings_of, source, message):
    (folder / "mine.py").write_text(f"def drive(run):\n    {source}\n")

    [result] = results_of(settings_of(controllers='[{name: a, call: "mine.py:drive"}]', seeds=1))

    assert message in result.error


def test_a_controller_may_return_values_or_step_without_end(folder, settings_of):
    (folder / "both.py").write_text(
        "import numpy\n"
        "def returns(run):\n"
        "    run.step(0.5)\n"
        "    return {'success': True, 'number': numpy.float32(0.5), 'count': numpy.int64(3)}\n"
        "def steps(run):\n"
        "    while True:\n"
        "        try:\n"
        "            run.step()\n"
        "        except Exception:\n"
        "            pass\n"
    )
    both = '[{name: a, call: "both.py:returns"}, {name: b, call: "both:steps"}]'

    first, second = results_of(settings_of(controllers=both, seeds=1))

    row = first.row
    assert (row["outcome"], row["time"], row["success"]) == ("returned", 0.5, True)
    assert first.returned == {"number": 0.5, "count": 3}
    assert (second.row["outcome"], second.error) == ("time limit", "")


def test_an_observer_changes_nothing(settings_of):
    settings = settings_of(seeds=1)
    [scenario] = scenarios_of(settings)
    steps = []

    class Observer(RunObserver):
        def on_step(self, run):
            steps.append(run.time)

    plain = ScenarioRunner(settings).run(scenario)
    watched = ScenarioRunner(settings).run(scenario, Observer())

    assert watched == plain
    assert len(steps) == round(plain.row["time"] / settings.step_size)


@pytest.mark.parametrize(
    ("pose", "expression"),
    [
        ("[0, 2, 0.3]", """["$eval param('/x', 0) + math.random()", 2, 0.3]"""),  # of the box
        ("[-3, 0, 0]", """["$eval -3 + math.random()", 0, 0]"""),  # of the robot
    ],
)
def test_expressions_vary_with_the_seed_and_not_with_scenarios_before(
    folder, settings_of, pose, expression
):
    edit_world(folder, pose, expression)
    task = {"controllers": None, "start": None, "seeds": 3, "time_limit": 0.05}
    settings = settings_of(parameters="{/x: [0, 1]}", **task)

    results = results_of(settings)

    assert {result.error for result in results} == {""}
    starts = {s.seed: r.row["start_x"] for s, r in zip(scenarios_of(settings), results)}
    assert len(set(starts.values())) == (3 if "-3" in expression else 1)
    runner = ScenarioRunner(settings)
    for scenario, result in [*zip(scenarios_of(settings), results)][::-1]:
        assert runner.run(scenario) == result


def test_starts_do_not_depend_on_the_walls_of_scenarios_before(folder, settings_of):
    wall = "layer: walls, robot_name: robot, num_of_walls: 1, wall_wall_dist: 0.8"
    edit_world(folder, "models:", f"plugins: [{{type: RandomWall, name: more, {wall}}}]\nmodels:")
    settings = settings_of(seeds=2, controllers=None, time_limit=0.05)

    results = results_of(settings)

    assert results[1].error == ""
    runner = ScenarioRunner(settings)
    assert runner.run(scenarios_of(settings)[1]) == results[1]


def test_a_world_with_several_robots_needs_the_name_of_one(folder, settings_of):
    second = "{name: other, model: robot.model.yaml, pose: [3, 0, 0], namespace: other}"
    edit_world(folder, "models:", f"models:\n  - {second}")

    [refused] = results_of(settings_of(seeds=1))
    [driven] = results_of(settings_of(seeds=1, robot="other"))

    assert 'the key "robot" to name one of several; found other, robot' in refused.error
    assert driven.error == ""


# Clearance


def brute_force(points, segments):
    """The distance of densely sampled outlines."""
    ends = segments.reshape(-1, 2, 2)
    along = np.linspace(0.0, 1.0, 400)[:, None]
    samples = np.concatenate([a + along * (b - a) for a, b in ends])
    return np.hypot(*(points[:, None, :] - samples).T).min()


@pytest.mark.parametrize("shape", ["circle", "polygon"])
def test_the_clearance_is_the_distance_of_outlines(shape):
    corners = [[0.3, -0.2], [0.3, 0.2], [-0.4, 0.2], [-0.4, -0.2]]
    footprints = {
        "circle": {"type": "circle", "radius": 0.25, "density": 1},
        "polygon": {"type": "polygon", "points": corners, "density": 1},
    }
    square = [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]
    box = {"type": "polygon", "points": square, "density": 1}
    robot = footprints[shape]
    models = [
        {"name": name, "model": {"bodies": [{"name": "body", "footprints": [footprint]}]}}
        for name, footprint in (("robot", robot), ("box", box))
    ]
    world = {"properties": {}, "layers": [], "models": models}
    rng = np.random.default_rng(1)
    with Simulation(world) as simulation:
        for _ in range(25):
            pose = rng.uniform((-3, -3, -4), (3, 3, 4))
            simulation.move("robot", pose)
            bodies = simulation.models["robot"].model.physics_bodies
            clearance = _core.BodyGroup(bodies).clearance(math.inf)

            sides = np.hstack([np.array(square), np.roll(square, -1, axis=0)])
            if shape == "circle":
                outline, radius = pose[None, :2], 0.25
            else:
                ring = np.array([Pose(*pose).apply(*corner) for corner in corners])
                along = np.linspace(0, 1, 50)[:, None]
                pairs = zip(ring, np.roll(ring, -1, axis=0))
                outline, radius = np.concatenate([a + along * (b - a) for a, b in pairs]), 0.0
            expected = max(0.0, brute_force(outline, sides) - radius)
            if simulation.models["robot"].model.overlapping():
                assert clearance <= 0.02  # Box2D's polygons have a skin of 0.01 m
            else:
                assert clearance == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("without", ["", "box"])
def test_the_least_clearance_of_a_way_is_that_of_all_its_poses(folder, without):
    """Skipping obstacles that cannot be nearer than the least clearance makes no difference."""
    with Simulation(folder / "world.yaml") as simulation:
        if without:
            simulation.delete(without)  # the walls are the nearest
        robot = simulation.models["robot"].model
        group = _core.BodyGroup(robot.physics_bodies)
        on_the_way = least = math.inf
        for number in range(150):
            angle, reach = number * 0.1, 0.3 + 0.02 * number
            x, y = reach * math.cos(angle), reach * math.sin(angle) - 0.2
            simulation.move("robot", [x, y, angle])
            on_the_way = group.clearance(on_the_way)
            least = min(least, group.clearance(math.inf))
            assert on_the_way == least
    assert (least == 0.0) == (not without)
