"""Scenario files: their settings, their scenarios, and errors in them."""

import time

import pytest
from soak.mutations import LAUGHS

from flatland2d.sweep.fingerprints import Fingerprints
from flatland2d.sweep.parameters import combinations, set_value
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import scenario_of, scenarios_of
from flatland_server.exceptions import FlatlandError, UsageError, YamlError
from flatland_server.geometry import Pose

BOX_CHOSEN_BY_PARAMETER = (
    "{name: box, model: box.model.yaml, pose: [0, 2, 0.3]}",
    'name: box\n    pose: [0, 2, 0.3]\n    model: $eval param("/box", "box") .. ".model.yaml"',
)
"""A string of the world file, and its replacement."""


def test_worlds_may_be_names_and_maps(settings_of):
    worlds = "[office, {name: b, world: world.yaml, goal_radius: 0.5}, world.yaml]"
    settings = settings_of(worlds=worlds)

    assert [each.name for each in settings.worlds] == ["office", "b", settings.worlds[2].name]
    assert [each.task.goal_radius for each in settings.worlds][1:] == [0.5, 0.3]


def test_the_order_is_world_controller_parameters_seed(settings_of):
    settings = settings_of(
        worlds="[office, world.yaml]",
        controllers='[{name: a, call: "drivers.py:ahead"}, {name: none}]',
        parameters="{/range: [3, 4], controller.speed: 0.5}",
        seeds="[7, 3]",
    )

    found = scenarios_of(settings)

    assert len(found) == 16
    assert [each.number for each in found] == list(range(1, 17))
    assert [each.seed for each in found[:4]] == [7, 3, 7, 3]
    assert [each.parameters["/range"] for each in found[:4]] == [3, 3, 4, 4]
    assert [each.controller.name for each in found[::4]] == ["a", "none", "a", "none"]
    assert [each.world.name for each in found[::8]] == ["office", found[8].world.name]
    assert str(found[1]).startswith(
        "scenario 2 (world office, controller a, /range = 3, controller.speed = 0.5, seed 3)"
    )
    with pytest.raises(UsageError, match="a scenario of 1 to 16, found 17"):
        scenario_of(settings, 17)


@pytest.mark.parametrize(
    ("written", "seeds"),
    [("3", (0, 1, 2)), ("[5, 1]", (5, 1)), ("{first: 10, count: 2}", (10, 11)), (None, (0,))],
)
def test_seeds(settings_of, written, seeds):
    assert settings_of(seeds=written).seeds == seeds


def test_a_world_has_a_task_of_its_own_or_that_of_the_file(settings_of):
    settings = settings_of(
        worlds="[{name: a, world: world.yaml},"
        " {name: b, world: world.yaml, goal: [1, 2], start: [0, 0, 1]}]"
    )

    a, b = (world.task for world in settings.worlds)
    assert (a.start, a.goal, a.goal_distance) == ("random", "random", (1.0, 3.0))
    assert (b.start, b.goal, b.goal_distance) == (Pose(0, 0, 1), (1.0, 2.0), (1.0, 3.0))


def test_a_shipped_scene_has_its_own_goal_by_default(settings_of):
    scenes = "[crossing, {name: other, world: circle_crossing, goal: [1, 2]}, office]"
    of_the_file = settings_of(worlds="[crossing]").worlds[0].task.goal
    settings = settings_of(worlds=scenes, goal=None)

    assert [world.task.goal for world in settings.worlds] == [(5.0, 0.0), (1.0, 2.0), None]
    assert of_the_file == "random"


@pytest.mark.parametrize("call", ["drivers:gaps", "orca:orca"])
def test_a_controller_that_needs_a_goal_is_refused_without_one(settings_of, call):
    controllers = f'[{{name: gaps, call: "flatland2d.sweep.{call}"}}]'
    with pytest.raises(YamlError, match='goal in world "office", to which the controller "gaps"'):
        settings_of(worlds="[office, crossing]", goal=None, controllers=controllers)


def test_expressions_and_includes_are_resolved(folder, settings_of):
    (folder / "seeds.yaml").write_text("[4, 5]")
    settings = settings_of(seeds="$include seeds.yaml", time_limit="$eval 2 * 3")

    assert (settings.seeds, settings.time_limit) == ((4, 5), 6.0)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"wrlds": "[office]"}, 'unknown key "wrlds"'),
        ({"worlds": None}, 'the required key "worlds" is missing'),
        ({"worlds": "[ofice]"}, 'no world is named "ofice" (did you mean "office"?)'),
        ({"worlds": "[no.yaml]"}, "no.yaml is not there"),
        ({"worlds": "[office, office]"}, 'the name "office" is given twice'),
        ({"worlds": "[{name: a, world: office, gaol: random}]"}, 'did you mean "goal"?'),
        ({"controllers": "[{name: a, call: drivers.py}]"}, 'a function as "module:function"'),
        ({"controllers": '[{name: a, call: "no.py:drive"}]'}, "no.py is not there"),
        ({"controllers": "[{name: a, policy: no.npz}]"}, "no.npz is not there"),
        ({"start": "here"}, 'expected [x, y, yaw] or random, found "here"'),
        ({"goal": "[1, 2, 3]"}, "expected [x, y], found [1, 2, 3]"),
        ({"goal_distance": "[3, 1]"}, "the least and the largest distance"),
        ({"seeds": "[1, 1]"}, "the seed 1 is given twice"),
        ({"seeds": "0"}, "a whole number of 1 or more"),
        ({"seeds": "[²]"}, 'expected seeds of 0 or more, of at most 30 digits, found "²"'),
        ({"seeds": f"[{'9' * 5000}]"}, "at most 30 digits"),
        ({"parameters": "{speed: [1, 2]}"}, '"models.name.pose", found "speed"'),
        ({"parameters": "{/a: []}"}, "expected a value or a list of values"),
        (
            {"parameters": str({f"/{name}": list(range(100)) for name in "abcdefgh"})},
            "expected at most 10000000 combinations of values, found 10000000000000000",
        ),
        ({"parameters": "{/a: [1, 1]}"}, "a combination of values is given twice"),
        ({"control_period": "0.007"}, "control_period to be a multiple of the step_size"),
        ({"step_size": "0"}, "a number above 0"),
    ],
)
def test_problems_are_reported_with_their_place(settings_of, keys, message):
    with pytest.raises(YamlError) as error:
        settings_of(**keys)

    assert message in str(error.value)
    assert str(error.value).count("scenarios.yaml:") == 1  # no errors that only follow from it


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"controllers": '[{name: a, call: "drivers.py:ahed"}]'}, 'did you mean "ahead"?'),
        ({"controllers": '[{name: a, call: "no_module:drive"}]'}, "cannot be imported"),
        (
            {"controllers": '[{name: a, call: "drivers.py:ahead", arguments: {sped: 1}}]'},
            "unexpected keyword argument 'sped'",
        ),
        ({"parameters": "{models.robt.pose: [[0, 0, 0]]}"}, 'did you mean "robot"?'),
        ({"parameters": "{models.robot.plugins.lasr.range: 2}"}, 'did you mean "laser"?'),
        ({"parameters": "{models.robot.plugins.².range: 2}"}, 'there is no "²"'),
    ],
)
def test_controllers_and_paths_are_checked_before_any_scenario(settings_of, keys, message):
    with pytest.raises(FlatlandError) as error:
        Fingerprints(settings_of(**keys))

    assert message in str(error.value)


@pytest.mark.parametrize("key", ["/a", "x"])
def test_an_alias_bomb_is_refused_before_it_is_expanded(settings_of, key):
    begin = time.process_time()
    with pytest.raises(YamlError) as error:
        settings_of(laughs="1\n" + LAUGHS, parameters=f"{{{key}: *a8}}")

    assert "expected at most 1000000 keys and values, each use of an alias" in str(error.value)
    assert time.process_time() - begin < 6.0


def test_combinations_of_several_grids():
    pairs = [{"/a": a, "/b": b} for a in (1, 2) for b in (3, 4)]

    assert combinations([{"/a": [1, 2], "/b": [3, 4]}, {"/a": 5}]) == [*pairs, {"/a": 5}]


def test_values_in_a_world_are_found_by_names_and_numbers():
    plugin = {"name": "laser", "range": 5}
    robot = {"name": "robot", "pose": [0, 0, 0], "model": {"plugins": [plugin]}}
    world = {"models": [robot]}

    set_value(world, "models.robot.plugins.laser.range", 3)
    set_value(world, "models.robot.model.plugins.laser.noise_std_dev", 0.1)
    set_value(world, "models.0.pose.2", 1.5)

    assert plugin == {"name": "laser", "range": 3, "noise_std_dev": 0.1}
    assert robot["pose"] == [0, 0, 1.5]


def test_a_fingerprint_covers_all_that_a_result_depends_on(folder, settings_of):
    def fingerprints(**keys):
        settings = settings_of(**keys)
        return [Fingerprints(settings).of(each) for each in scenarios_of(settings)]

    first = fingerprints(seeds=4)
    assert len(set(first)) == 4
    assert fingerprints(seeds=5)[:4] == first
    assert fingerprints(seeds=4, retries=5, real_time_limit=3) == first
    for keys in (
        {"time_limit": 4},
        {"goal": "[1, 0]"},
        {"parameters": "{/range: 5}"},
        {"controllers": '[{name: a, call: "drivers.py:towards", arguments: {speed: 0.4}}]'},
    ):
        assert not set(fingerprints(**{"seeds": 4, **keys})) & set(first), keys
    for name in ("walls.dat", "robot.model.yaml", "drivers.py"):
        before = (folder / name).read_text()
        changed = before.replace("-4 -4 4 -4", "-4 -4 4 -3").replace("0.2", "0.3")
        (folder / name).write_text(changed.replace("scan = 0.0", "scan = 1.0"))
        assert not set(fingerprints(seeds=4)) & set(first), name
        (folder / name).write_text(before)
    assert fingerprints(seeds=4) == first


def test_a_fingerprint_covers_recorded_people(folder, settings_of, monkeypatch, tmp_path):
    with (folder / "world.yaml").open("a") as world:
        world.write("plugins: [{type: Crowd, name: people, recording: {file: people.csv}}]\n")

    def fingerprint(rows):
        (folder / "people.csv").write_text(rows)
        settings = settings_of()
        return Fingerprints(settings).of(scenarios_of(settings)[0])

    first = fingerprint("0 1 0 0")
    monkeypatch.chdir(tmp_path)  # the file is beside that of the world

    assert fingerprint("0 1 0 0") == first
    assert fingerprint("0 1 0 0.1") != first


def test_a_fingerprint_covers_files_chosen_by_parameters(folder, settings_of, monkeypatch):
    for name in ("crate.model.yaml", "case.model.yaml"):
        (folder / name).write_text((folder / "box.model.yaml").read_text())
    (folder / "hall.yaml").write_text((folder / "walls.yaml").read_text().replace("walls", "hall"))
    (folder / "hall.dat").write_text((folder / "walls.dat").read_text())
    world = (folder / "world.yaml").read_text()
    (folder / "world.yaml").write_text(world.replace(*BOX_CHOSEN_BY_PARAMETER))
    settings = settings_of(
        parameters="[{/box: [box, crate]}, {models.box.model: case.model.yaml}, "
        "{layers.walls.map: hall.yaml}]",
        seeds=1,
    )
    monkeypatch.chdir("/")  # the files are found beside the scenario file

    def fingerprints():
        found = Fingerprints(settings)
        return [found.of(each) for each in scenarios_of(settings)]

    former = fingerprints()
    for number, file in ((1, "crate.model.yaml"), (2, "case.model.yaml"), (3, "hall.dat")):
        content = (folder / file).read_text()
        (folder / file).write_text(content.replace("0.5", "0.6").replace("-4 -4 4", "-4 -4.5 4"))
        now = fingerprints()
        assert [a != b for a, b in zip(former, now)] == [n == number for n in range(4)], file
        former = now
    runner = ScenarioRunner(settings)
    assert [runner.run(each).error for each in scenarios_of(settings)] == [""] * 4


@pytest.mark.parametrize(
    ("keys", "unused"),
    [
        ({"parameters": "{/box: box, /bxo: [0, 1], models.box.pose.1: 3}"}, ["/bxo"]),
        ({"parameters": "{controller.speed: 1}", "controllers": None}, ["controller.speed"]),
    ],
)
def test_a_parameter_that_changes_nothing_is_named(folder, settings_of, keys, unused):
    world = (folder / "world.yaml").read_text()
    (folder / "world.yaml").write_text(world.replace(*BOX_CHOSEN_BY_PARAMETER))

    assert Fingerprints(settings_of(**keys)).unused == unused
