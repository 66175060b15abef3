"""The worlds that come with Flatland, by name."""

from pathlib import Path

import pytest

from flatland_server.config import worlds as module
from flatland_server.config.worlds import find_world, shipped_worlds
from flatland_server.exceptions import FlatlandError

PACKAGE = Path(__file__).resolve().parents[2]
SCENES = ("circle_crossing", "corridor_frontal", "crossing", "doorway", "intersection")
WORLDS = (*SCENES, "office", "overtaking", "racetrack", "test_room")


def test_the_worlds_are_found_beside_the_sources():
    assert shipped_worlds() == {name: PACKAGE / "worlds" / name / "world.yaml" for name in WORLDS}


@pytest.mark.parametrize(
    ("package", "worlds"),
    [
        ("lib/python3/dist-packages/flatland_server", "share/flatland_server/worlds"),
        ("lib/python3.8/site-packages/flatland_server", "share/flatland_server/worlds"),
        (
            "lib/python3.8/site-packages/flatland_server",
            "lib/python3.8/site-packages/flatland_server/worlds",
        ),
    ],
    ids=["catkin", "catkin, another Python", "wheel"],
)
def test_the_worlds_are_found_where_they_are_installed(tmp_path, monkeypatch, package, worlds):
    office = tmp_path / worlds / "office" / "world.yaml"
    office.parent.mkdir(parents=True)
    office.touch()
    monkeypatch.setattr(module, "_PACKAGE", tmp_path / package)

    assert shipped_worlds() == {"office": office}


def test_a_world_is_found_by_its_name_or_its_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "office").touch()
    (tmp_path / "hall").touch()

    assert find_world("test_room") == shipped_worlds()["test_room"]
    assert find_world("hall") == Path("hall")
    for path in ("./office", "offise.yaml", "/none/world.yaml"):
        assert find_world(path) == Path(path)
    assert find_world(Path("none")) == Path("none")
    assert find_world("package://flatland_server/worlds/office/world.yaml").samefile(
        shipped_worlds()["office"]
    )


def test_the_error_for_an_unknown_world_lists_all_worlds(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    with pytest.raises(FlatlandError) as error:
        find_world("offise")

    assert str(error.value) == (
        'no world is named "offise" (did you mean "office"?); '
        f"there are: {', '.join(WORLDS)}, and any file by its path"
    )
