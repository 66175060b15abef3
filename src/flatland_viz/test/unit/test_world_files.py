"""Names of a world's files, and whether they are the user's."""

from pathlib import Path

import pytest

from flatland_viz.world_files import copy_of, is_installed, label, title
from flatland_viz.world_menu import names_of


@pytest.mark.parametrize(
    ("file", "name"),
    [("box.model.yaml", "box"), ("rover.yaml", "rover"), ("a.b.model.yaml", "a.b")],
)
def test_names_of_models_have_no_ending(file, name):
    assert label(Path("/worlds") / file) == name


def test_names_of_recent_worlds_tell_files_apart():
    paths = ["/x/office/world.yaml", "/y/office/world.yaml", "/x/room/world.yaml"]
    assert names_of(paths) == [*paths[:2], "room/world.yaml"]


def test_the_title_names_the_world_with_its_folder():
    assert title("/home/me/worlds/office/world.yaml") == "Flatland - office/world.yaml[*]"
    assert title("") == "Flatland[*]"


@pytest.mark.parametrize(
    ("folder", "package", "is_other"),
    [
        ("src/my_robots", "my_robots", False),
        ("share/my_robots", "my_robots", True),  # an install space
        ("src/flatland_server", "flatland_server", True),
        ("worlds", None, False),
    ],
)
def test_worlds_in_install_spaces_are_not_the_users(tmp_path, folder, package, is_other):
    place = tmp_path / folder
    (place / "worlds").mkdir(parents=True)
    world = place / "worlds" / "world.yaml"
    world.touch()
    if package is not None:
        (place / "package.xml").write_text(f"<package><name> {package}</name></package>")

    assert is_installed(world) == is_other
    link = tmp_path / "link.yaml"
    link.symlink_to(world)
    assert is_installed(link) == is_other
    assert not is_installed(place / "nowhere" / "world.yaml")  # on another machine


def test_a_copy_is_named_after_the_world():
    assert copy_of(Path("/worlds/office/world.yaml")) == Path.home() / "office.yaml"
    assert copy_of(Path("/worlds/floor_2.yaml")) == Path.home() / "floor_2.yaml"
    assert copy_of(Path("")) == Path.home() / "world.yaml"
