"""Loading: where files are looked for, and that a world or model loads completely or not at all."""

import pytest

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.simulation.run import Run
from flatland_server.simulation.world_config import WorldConfig
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport

DISC = "{bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]}"
FILES = [
    # the file that names another one, the key, its value
    ("world.yaml", "map", "map.yaml"),
    ("world.yaml", "model", "robot.model.yaml"),
    ("map.yaml", "image", "map.png"),
    ("lines.yaml", "data", "lines.dat"),
]


@pytest.mark.parametrize("is_absolute", [True, False], ids=["absolute", "relative"])
@pytest.mark.parametrize(("file", "key", "name"), FILES)
def test_a_file_may_be_elsewhere(good_files, monkeypatch, is_absolute, file, key, name):
    """A path is relative to the file that names it, whatever the working directory is."""
    elsewhere = good_files.folder / "sub"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    for other in [name, *{"map.yaml": ["map.png"]}.get(name, [])]:
        (good_files.folder / other).rename(elsewhere / other)
    path = elsewhere / name if is_absolute else f"sub/../sub/{name}"
    good_files.edit(file, f"{key}: {name}", f"{key}: {path}")

    world = good_files.load()

    assert all(len(layer.segments) for layer in world.layers[:2])


@pytest.mark.parametrize(
    "discs",
    [
        {"disc.yaml": DISC},
        {"parts/disc.yaml": DISC},
        {"disc.yaml": DISC, "parts/disc.yaml": "wrong: true\n"},  # the root document's comes first
    ],
)
def test_a_file_in_an_include_is_relative_to_the_root_or_to_it(files, discs):
    files.write("world.yaml", "properties: {}\nlayers: []\nmodels: $include parts/models.yaml\n")
    files.write("parts/models.yaml", "- {name: disc, model: disc.yaml}\n")
    assert files.refusal() == (
        "parts/models.yaml:1: models[0].model: expected a file, but disc.yaml is not there"
    )
    for name, text in discs.items():
        files.write(name, text)

    assert list(files.load().models) == ["disc"]


def test_reading_a_world_starts_nothing(good_files):
    good_files.edit("robot.model.yaml", "type: DiffDrive", "type: NoSuchPlugin")

    config = WorldConfig.from_file(good_files.folder / "world.yaml")

    assert config.models[0].model.plugins[0].type == "NoSuchPlugin"


FAULTS = [
    ("radius: 0.5", "radius: 0"),
    ("range: 10", "range: 0"),
    ("range: 10", "raneg: 10"),
    ("type: Laser", "type: Lasre"),
    ("anchor: [0.5, 0]", "anchor: [1e6, 0]"),
    ("name: wheel", "name: wheel\n    pose: [1e6, 0, 0]"),
    ("layers: [map, walls]", "layers: [none]"),
    ("bodies:", "bodies: ["),
]
"""Texts of a model file, and the texts that replace them."""


@pytest.mark.parametrize(("old", "new"), FAULTS)
def test_a_world_that_is_refused_leaves_no_topics_behind(good_files, old, new):
    good_files.edit("robot.model.yaml", old, new)
    transport = LocalTransport()

    with pytest.raises(FlatlandError):
        good_files.load(transport=transport)

    assert transport.topics == set()
    assert transport.subscribed == set()


@pytest.mark.parametrize(("old", "new"), FAULTS)
def test_a_model_that_is_refused_leaves_the_world_as_it_was(good_files, old, new):
    transport = LocalTransport()
    world = good_files.load(transport=transport)
    run = Run(world, Timekeeper(0.005)).step()

    def facts():
        physics = (world.physics.body_count, world.physics.joint_count)
        topics = (transport.topics, transport.subscribed, set(transport.transforms))
        return (list(world.models), *physics, *topics, world.plugin_count)

    before = facts()
    path = good_files.folder / "robot.model.yaml"
    good_files.edit("robot.model.yaml", old, new)

    with pytest.raises(FlatlandError):
        world.spawn_model(path, "second", "r2", Pose())
    run.step()

    assert facts() == before
    good_files.edit("robot.model.yaml", new, old)
    world.spawn_model(path, "second", "r2", Pose())
    assert list(world.models) == ["robot", "second"]


def test_all_problems_of_a_spawned_model_are_reported(good_files):
    world = good_files.load()
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: 0")
    good_files.edit("robot.model.yaml", "[-1, 1]", "[1, -1]")

    with pytest.raises(FlatlandError) as caught:
        world.spawn_model(good_files.folder / "robot.model.yaml", "second", "", Pose())

    assert good_files.without_folder(str(caught.value)).splitlines() == [
        "robot.model.yaml:11: bodies[0].footprints[0].radius: expected a number above 0, found 0",
        "robot.model.yaml:27: joints[0].limits: expected [lower, upper], found 1 above -1",
    ]
