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


@pytest.mark.parametrize(("file", "key", "name"), FILES)
def test_a_file_may_be_absolute(good_files, tmp_path_factory, file, key, name):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    others = {"map.yaml": ["map.png"], "robot.model.yaml": []}.get(name, [])
    for other in [name, *others]:
        (good_files.folder / other).rename(elsewhere / other)
    good_files.edit(file, f"{key}: {name}", f"{key}: {elsewhere / name}")

    good_files.load().close()


@pytest.mark.parametrize(("file", "key", "name"), FILES)
def test_a_file_is_relative_to_the_one_that_names_it(good_files, file, key, name):
    (good_files.folder / "sub").mkdir()
    others = {"map.yaml": ["map.png"]}.get(name, [])
    for other in [name, *others]:
        (good_files.folder / other).rename(good_files.folder / "sub" / other)
    good_files.edit(file, f"{key}: {name}", f"{key}: sub/{name}")

    good_files.load().close()


def test_a_map_in_another_folder_may_have_its_image_beside_it(files):
    files.write_good_ones()
    for name in ("map.yaml", "map.png", "lines.yaml", "lines.dat"):
        files.write(f"maps/{name}", (files.folder / name).read_bytes())
        (files.folder / name).unlink()
    files.edit("world.yaml", "map: map.yaml", "map: maps/../maps/map.yaml")
    files.edit("world.yaml", "map: lines.yaml", "map: maps/lines.yaml")

    world = files.load()

    assert all(len(layer.segments) for layer in world.layers[:2])


def test_the_working_directory_does_not_matter(good_files, monkeypatch, tmp_path):
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")

    good_files.load().close()


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
    for name, text in discs.items():
        files.write(name, text)

    assert list(files.load().models) == ["disc"]


def test_a_missing_file_is_named_beside_the_root_document(files):
    files.write("world.yaml", "properties: {}\nlayers: []\nmodels: $include parts/models.yaml\n")
    files.write("parts/models.yaml", "- {name: disc, model: disc.yaml}\n")

    assert files.refusal() == (
        "parts/models.yaml:1: models[0].model: expected a file, but disc.yaml is not there"
    )


def test_reading_a_world_starts_nothing(good_files):
    good_files.edit("robot.model.yaml", "type: DiffDrive", "type: NoSuchPlugin")

    config = WorldConfig.from_file(good_files.folder / "world.yaml")

    assert config.models[0].model.plugins[0].type == "NoSuchPlugin"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("radius: 0.5", "radius: 0"),
        ("range: 10", "range: 0"),
        ("range: 10", "raneg: 10"),
        ("type: Laser", "type: Lasre"),
        ("anchor: [0.5, 0]", "anchor: [1e6, 0]"),
        ("name: wheel", "name: wheel\n    pose: [1e6, 0, 0]"),
    ],
)
def test_a_world_that_is_refused_leaves_no_topics_behind(good_files, old, new):
    good_files.edit("robot.model.yaml", old, new)
    transport = LocalTransport()

    with pytest.raises(FlatlandError):
        good_files.load(transport=transport)

    assert transport.topics == set()
    assert transport.subscribed == set()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("radius: 0.5", "radius: 0"),
        ("range: 10", "range: 0"),
        ("range: 10", "raneg: 10"),
        ("type: Laser", "type: Lasre"),
        ("layers: [map, walls]", "layers: [none]"),
        ("anchor: [0.5, 0]", "anchor: [1e6, 0]"),
        ("bodies:", "bodies: ["),
    ],
)
def test_a_model_that_is_refused_leaves_the_world_as_it_was(good_files, old, new):
    transport = LocalTransport()
    world = good_files.load(transport=transport)
    run = Run(world, Timekeeper(0.005)).step()
    before = (
        list(world.models),
        world.physics.body_count,
        world.physics.joint_count,
        transport.topics,
        transport.subscribed,
        set(transport.transforms),
        world.plugin_count,
    )
    good_files.edit("robot.model.yaml", old, new)

    with pytest.raises(FlatlandError):
        world.spawn_model(good_files.folder / "robot.model.yaml", "second", "r2", Pose())
    run.step()

    assert before == (
        list(world.models),
        world.physics.body_count,
        world.physics.joint_count,
        transport.topics,
        transport.subscribed,
        set(transport.transforms),
        world.plugin_count,
    )


def test_a_model_can_be_spawned_after_its_file_was_corrected(good_files):
    world = good_files.load()
    path = good_files.folder / "robot.model.yaml"
    good_files.edit("robot.model.yaml", "range: 10", "range: 0")
    with pytest.raises(FlatlandError):
        world.spawn_model(path, "second", "r2", Pose())
    good_files.edit("robot.model.yaml", "range: 0", "range: 10")

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
