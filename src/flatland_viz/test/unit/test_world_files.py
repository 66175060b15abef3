"""The models in the window's menu, and their names."""

from pathlib import Path

import pytest

from flatland_viz.world_files import label, model_files, title


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a world and two models, and a third model in another folder."""
    (tmp_path / "world").mkdir()
    (tmp_path / "robots").mkdir()
    for name in ("world/crate.model.yaml", "world/arm.model.yaml", "robots/rover.yaml"):
        (tmp_path / name).write_text("bodies: []")
    (tmp_path / "world" / "map.yaml").write_text("image: map.png")
    return tmp_path.resolve()


def write_world(folder: Path, text: str) -> Path:
    """The world's file."""
    world = folder / "world" / "world.yaml"
    world.write_text(text)
    return world


def test_models_in_the_worlds_folder_come_before_those_that_it_names(folder):
    world = write_world(
        folder, "models: [{name: a, model: ../robots/rover.yaml}, {name: b, model: arm.model.yaml}]"
    )

    assert model_files(world) == [
        folder / "world" / "arm.model.yaml",
        folder / "world" / "crate.model.yaml",
        folder / "robots" / "rover.yaml",
    ]


def test_an_absolute_path_is_taken_as_it_is(folder):
    world = write_world(folder, f"models: [{{model: {folder}/robots/rover.yaml}}]")

    assert model_files(world)[-1] == folder / "robots" / "rover.yaml"


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("models: [{model: missing.model.yaml}]", id="a missing file"),
        pytest.param("models: [{model: {$eval: name}}, 3]", id="no plain names"),
        pytest.param("models: none", id="no list"),
        pytest.param("- 1", id="no map"),
        pytest.param("a: [", id="no YAML"),
        pytest.param("a: !lua x", id="a tag"),
        pytest.param("", id="empty"),
    ],
)
def test_a_world_without_readable_names_still_offers_its_folder(folder, text):
    files = model_files(write_world(folder, text))

    assert [file.name for file in files] == ["arm.model.yaml", "crate.model.yaml"]


def test_a_world_that_is_not_on_this_machine_offers_nothing(tmp_path):
    assert model_files(tmp_path / "elsewhere" / "world.yaml") == []


@pytest.mark.parametrize(
    ("file", "name"),
    [("box.model.yaml", "box"), ("rover.yaml", "rover"), ("a.b.model.yaml", "a.b")],
)
def test_names_of_models_have_no_ending(file, name):
    assert label(Path("/worlds") / file) == name


def test_the_title_names_the_world_with_its_folder():
    assert title("/home/me/worlds/office/world.yaml") == "Flatland - office/world.yaml[*]"
    assert title("") == "Flatland[*]"
