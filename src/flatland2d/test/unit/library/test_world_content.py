"""world_content: a world as one dict; and simulations of a WorldConfig."""

import numpy as np
import pytest

from flatland2d import FlatlandError, Simulation, world_content
from flatland_server import WorldConfig


def drive(world):
    with Simulation(world, seed=3) as simulation:
        simulation.models["turtlebot"].command(0.9, 0.4)
        simulation.step(600)
        scan = simulation.models["turtlebot"].sensors["laser"].read()
        return simulation.poses.tobytes() + scan.tobytes()


def test_the_content_gives_the_run_of_the_files():
    content = world_content("office")
    config = WorldConfig.from_content(content)

    assert drive(content) == drive("office")
    assert drive(config) == drive(config) == drive("office")


def test_includes_expressions_and_folders_are_resolved(tmp_path):
    models = tmp_path / "models"
    models.mkdir()
    (models / "box.model.yaml").write_text(
        "bodies: [{name: box, footprints: [$include footprint.yaml]}]\n"
    )
    (models / "footprint.yaml").write_text(
        'type: circle\nradius: $eval param("/radius", 0.25)\ndensity: 1e1\nfriction: 0x2\n'
    )
    (tmp_path / "world.yaml").write_text(
        "properties: {}\nlayers: [{name: none}]\nmodels:\n"
        "  - {name: '7', pose: [1, 2.5, 0], model: box.model.yaml}\n"
        "  - {name: absent, model: there_is_none.yaml, enabled: false}\n"
        "  - {name: other, model: {bodies: []}, namespace: ~}\n"
    )

    content = world_content(
        tmp_path / "world.yaml", params={"/radius": 0.5}, model_folders=[models]
    )

    footprint = {"type": "circle", "radius": 0.5, "density": "1e1", "friction": 2}
    box = {"bodies": [{"name": "box", "footprints": [footprint]}]}
    assert content == {
        "properties": {},
        "layers": [{"name": "none"}],
        "models": [
            {"name": "7", "pose": [1, 2.5, 0], "model": box},
            {"name": "other", "model": {"bodies": []}, "namespace": None},
        ],
    }


def test_the_content_of_a_dict_has_no_files_left():
    world = {"properties": {}, "layers": [], "models": [{"name": "a", "model": {"bodies": []}}]}
    content = world_content(world)
    assert content == world
    content["models"].clear()
    assert len(world["models"]) == 1


def test_missing_worlds_and_models_are_named(tmp_path):
    with pytest.raises(FlatlandError, match=r'no world is named "ofice" \(did you mean "office"'):
        world_content("ofice")
    (tmp_path / "world.yaml").write_text("models: [{name: a, model: b.yaml}]\nlayers: 3\n")
    with pytest.raises(FlatlandError, match=r"world.yaml:1: models\[0\].model: expected a file"):
        world_content(tmp_path / "world.yaml")


def test_simulations_of_one_config_are_independent():
    config = WorldConfig.from_content(world_content("test_room"))
    with Simulation(config, seed=1) as a, Simulation(config, seed=1) as b:
        a.models["turtlebot"].command(0.5, 0.5)
        a.step(100)
        assert not np.array_equal(a.poses, b.poses)
        b.models["turtlebot"].command(0.5, 0.5)
        b.step(100)
        assert np.array_equal(a.poses, b.poses)
