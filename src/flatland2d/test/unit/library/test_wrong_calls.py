"""Wrong calls raise a FlatlandError that says what was expected, and change nothing."""

import math

import numpy as np
import pytest
from library.parts import ROBOT, Float

from flatland2d import ModelError, Simulation, StateError, UsageError

WRONG = [
    (lambda sim: sim.step(0), UsageError, "a number of steps .* of 1 or more, found 0"),
    (lambda sim: sim.step(-1), UsageError, "found -1"),
    (lambda sim: sim.step(1.5), UsageError, "found 1.5"),
    (lambda sim: sim.step(True), UsageError, "found True"),
    (lambda sim: sim.step("2"), UsageError, "found '2'"),
    (lambda sim: sim.reset(seed="a"), UsageError, "a seed .* of 0 or more, found 'a'"),
    (lambda sim: sim.reset(seed=-1), UsageError, "found -1"),
    (lambda sim: sim.reset(1.0), UsageError, "found 1.0"),
    (lambda sim: sim.load_state(b"x"), StateError, "expected the state of a world"),
    (lambda sim: sim.models["robt"], ModelError, r'"robt" \(did you mean "robot"\?\); there are'),
    (lambda sim: sim.move("bx", [0, 0, 0]), ModelError, r'"bx" \(did you mean "box"\?\)'),
    (lambda sim: sim.delete("bx"), ModelError, 'there is no model "bx"'),
    (lambda sim: sim.move("box", [0, 0]), UsageError, r"expected a pose \[x, y, yaw\], found \[0"),
    (lambda sim: sim.move("box", "here"), UsageError, "found 'here'"),
    (lambda sim: sim.move("box", None), UsageError, "found None"),
    (lambda sim: sim.move("box", [0, 10**400, 0]), UsageError, r"\[x, y, yaw\], found \[0"),
    (lambda sim: sim.move("box", [0, math.nan, 0]), ModelError, "expected a finite pose, found"),
    (lambda sim: sim.spawn(ROBOT, 3), UsageError, "the model's name as a string, found 3"),
    (lambda sim: sim.spawn(ROBOT, "c", namespace=3), UsageError, "namespace as a string, found 3"),
    (
        lambda sim: sim.spawn(3, "c"),
        UsageError,
        "a model's file, or its content as a dict, found 3",
    ),
    (lambda sim: sim.move(3, [0, 0, 0]), ModelError, 'there is no model "3"'),
    (lambda sim: sim.delete(None), ModelError, 'there is no model "None"'),
    (lambda sim: sim.models["robot"].plugin(3), ModelError, 'has no plugin "3"'),
    (lambda sim: sim.keep_history(math.inf), UsageError, "an interval above 0, found inf"),
    (lambda sim: sim.keep_history(1, 10**400), UsageError, "expected a memory above 0, found 1000"),
    (lambda sim: sim.save_picture(3), UsageError, "expected the path of a picture, found 3"),
    (lambda sim: sim.render(follow="box", width="x"), UsageError, "a width above 0 m, found 'x'"),
    (lambda sim: sim.move("box", [1e9, 0, 0]), ModelError, "cannot be there"),
    (lambda sim: sim.spawn(ROBOT, "c", [0, math.inf, 0]), ModelError, "expected a finite pose"),
    (lambda sim: sim.spawn(ROBOT, "a b"), ModelError, "a b"),
    (lambda sim: sim.spawn("no.yaml", "c"), ModelError, r"there is no file /.*/no\.yaml"),
    (lambda sim: sim.models["robot"].command(math.nan), UsageError, r"finite numbers, found \(nan"),
    (lambda sim: sim.models["robot"].command(np.float32("inf")), UsageError, "finite numbers"),
    (lambda sim: sim.models["robot"].command(10**400), UsageError, "finite numbers, found"),
    (lambda sim: sim.subscribe(5), UsageError, "expected the name of a topic, found 5"),
    (lambda sim: sim.last(None), UsageError, "expected the name of a topic, found None"),
    (lambda sim: sim.record(5), UsageError, "expected the path of a recording, found 5"),
    (lambda sim: sim.record("run.bag", topics=5), UsageError, "expected topics as a list, found 5"),
    (
        lambda sim: sim.models["robot"].command(),
        UsageError,
        r'"robot/pusher" takes command\(speed, turn\), found \(\)$',
    ),
    (lambda sim: sim.models["robot"].command(1, 2, 3), UsageError, r"found \(1, 2, 3\)$"),
    (lambda sim: sim.models["robot"].command("a"), UsageError, r"found \('a',\): '>' not supp"),
    (lambda sim: sim.models["robot"].command(10), UsageError, r"found \(10,\): too fast"),
    (lambda sim: sim.models["box"].command(1), ModelError, 'one drive, "box" has none'),
    (lambda sim: sim.models["robot"].drives["x"], ModelError, 'has no drive "x"; it has: pusher'),
    (lambda sim: sim.models["robot"].sensors["pushr"], ModelError, 'did you mean "pusher"'),
    (
        lambda sim: sim.models["robot"].sensors["pusher"].read("sped"),
        UsageError,
        r'"robot/pusher" does not measure "sped" \(did you mean "speed"\?\)',
    ),
    (lambda sim: sim.models["robot"].plugin("x"), ModelError, 'has no plugin "x"; it has: pusher'),
    (lambda sim: sim.render(follow="bx"), ModelError, "bx"),
    (
        lambda sim: Simulation("office", model_folders="models"),
        UsageError,
        "expected model_folders as a list, found 'models'",
    ),
    (
        lambda sim: Simulation("office", model_folders=[3]),
        UsageError,
        "expected model_folders as paths, found 3",
    ),
]


@pytest.mark.parametrize(("call", "error", "message"), WRONG)
def test_a_wrong_call_is_refused_and_changes_nothing(sim, call, error, message):
    sim.step(3)
    before = sim.save_state()

    with pytest.raises(error, match=message):
        call(sim)

    assert sim.save_state() == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": 1.5}, "a seed .* found 1.5"),
        ({"seed": None}, "found None"),
        ({"step_size": 0}, "expected a step of 1e-9 to 1000 s, found 0"),
        ({"step_size": -0.1}, "found -0.1"),
        ({"step_size": math.nan}, "found nan"),
        ({"step_size": "fast"}, "found 'fast'"),
        ({"step_size": None}, "found None"),
        ({"simplify_map": 0.05}, "expected simplify_map to be 0, 1 or 2, found 0.05"),
        ({"simplify_map": -1}, "found -1"),
        ({"params": 3}, "expected params as a dict by name, found 3"),
        ({"params": {3: 4}}, "expected params as a dict by name"),
        ({"loader": 3}, "expected a PluginLoader as loader, found 3"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(UsageError, match=message):
        Simulation("no such world, which is not looked for", **options)


@pytest.mark.parametrize("topics", [5, [5]])
def test_topics_that_are_no_names_are_refused(topics):
    with pytest.raises(UsageError, match=r"expected (topics|the name of) .*, found 5"):
        Simulation("office", topics=topics)


def test_a_closed_simulation_says_so(sim):
    robot = sim.models["robot"]
    sim.close()
    sim.close()

    for call, *arguments in (
        *((sim.step,), (sim.reset,), (sim.load_state, b""), (sim.save_state,)),
        *((sim.spawn, ROBOT, "c"), (sim.move, "robot", [0, 0, 0]), (sim.delete, "robot")),
        *((sim.publish, "/command", Float()), (sim.last, "/speed"), (sim.subscribe, "/speed")),
        *((sim.record, "run.bag"), (robot.command, 1), (lambda: robot.sensors["pusher"],)),
    ):
        with pytest.raises(UsageError, match="the simulation is closed"):
            call(*arguments)
    assert sim.poses.shape == (2, 3)


def test_a_handle_of_a_deleted_model_says_so(sim):
    robot = sim.models["robot"]
    pusher = robot.sensors["pusher"]
    sim.delete("robot")

    for use in (lambda: robot.pose, lambda: robot.command(1), pusher.read, lambda: robot.velocity):
        with pytest.raises(ModelError, match='there is no model "robot"'):
            use()
    assert robot.name == "robot"
