"""Worlds and models that a simulation loads: by name, from files, and as dicts."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from library.parts import BODY, LOADER, ROBOT

from flatland2d import FlatlandError, Simulation, UsageError, YamlError


def plain(content):
    """A world with paths as strings, as in a file."""
    return json.loads(json.dumps(content, default=str))


def test_a_file_and_a_dict_make_the_same_world(world, tmp_path):
    path = tmp_path / "room.yaml"
    path.write_text(yaml.safe_dump(plain(world)))

    states = []
    for source in (path, str(path), world):
        sim = Simulation(source, loader=LOADER)
        sim.models["robot"].command(0.5)
        states.append(json.loads(sim.step(10).save_state()))

    for key in ("wall_counts", "plugins", "physics"):
        assert states[0][key] == states[1][key] == states[2][key]


def test_paths_in_a_dict_are_relative_to_the_working_directory(tmp_path, monkeypatch):
    (tmp_path / "box.yaml").write_text(yaml.safe_dump({"bodies": [BODY]}))
    (tmp_path / "bodies.yaml").write_text(yaml.safe_dump(BODY))
    monkeypatch.chdir(tmp_path)
    models = [
        {"name": "a", "model": "box.yaml"},
        {"name": "b", "model": {"bodies": ["$include bodies.yaml"]}},
    ]

    sim = Simulation({"properties": {}, "layers": [], "models": models})
    sim.spawn("box.yaml", "c")
    sim.spawn(Path("box.yaml"), "d")

    assert list(sim.models) == ["a", "b", "c", "d"]


def test_a_model_within_a_world_file(tmp_path):
    path = tmp_path / "world.yaml"
    entry = {"name": "a", "model": {"bodies": [{**BODY, "typ": "static"}]}}
    path.write_text(yaml.safe_dump({"properties": {}, "layers": [], "models": [entry]}))

    with pytest.raises(YamlError, match=r"world.yaml:\d+: models\[0\].model.bodies\[0\] .*\"typ\""):
        Simulation(path)


def test_expressions_and_parameters_in_a_dict(world):
    world["models"][0]["pose"] = ["$eval param('/start', 3) / 2", np.float32(0.25), 0]

    assert Simulation(world, loader=LOADER).models["robot"].pose == (1.5, 0.25, 0.0)
    for name in ("/start", "start"):  # as a topic's name
        sim = Simulation(world, loader=LOADER, params={name: 1})
        assert sim.models["robot"].pose == (0.5, 0.25, 0.0)


def test_later_changes_of_a_dict_do_not_matter(world):
    robot = {"bodies": [dict(BODY)], "plugins": list(ROBOT["plugins"])}
    sim = Simulation(world, loader=LOADER)
    sim.spawn(robot, "late", [-1, 0, 0])
    state = sim.save_state()

    robot["bodies"].clear()
    world["models"].clear()

    assert list(sim.reset().models) == ["robot", "box"]
    assert list(sim.load_state(state).models) == ["robot", "box", "late"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"models": [{"name": "a", "model": "no.yaml"}]}, r"^world: models\[0\].model: expect"),
        ({"modles": []}, r'^world: unknown key "modles" \(did you mean "models"\?\)'),
        ({"layers": [{"name": "a", "color": [1, 0]}]}, r"^world: layers\[0\].color: expected \["),
        ({"models": [{"name": object()}]}, r"^world: models\[0\].name: expected numbers, strings,"),
        ({"models": {1: 2}}, "^world: models: expected a string as a key, found 1"),
        ({"models": [{"name": "a", "model": {}}]}, r"models\[0\].model: the required key"),
    ],
)
def test_a_problem_in_a_dict_is_named_by_its_place(change, message):
    with pytest.raises(FlatlandError, match=message):
        Simulation({"properties": {}, "layers": [], **change})


def test_a_wrong_model_changes_nothing(sim):
    before = sim.save_state()
    with pytest.raises(YamlError, match=r'^model: bodies\[0\] "base": unknown key "colour"'):
        sim.spawn({"bodies": [{**BODY, "colour": [0, 0, 0, 1]}]}, "late")
    with pytest.raises(FlatlandError, match='a model named "box" is already there'):
        sim.spawn(ROBOT, "box")
    assert sim.save_state() == before


@pytest.mark.parametrize("source", [None, 3, ["office"]])
def test_values_that_are_no_world_are_refused(source):
    with pytest.raises(UsageError, match="expected the name of a world, the path of a world file"):
        Simulation(source)


def test_an_unknown_world_is_refused_with_what_there_is():
    with pytest.raises(FlatlandError, match=r'"ofice" \(did you mean "office"\?\); there are: '):
        Simulation("ofice")
    with pytest.raises(YamlError, match=r"ofice\.yaml: cannot be read: No such file"):
        Simulation(os.path.join(".", "ofice.yaml"))
