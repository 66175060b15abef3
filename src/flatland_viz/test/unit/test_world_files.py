"""Names of a world's files."""

from pathlib import Path

import pytest

from flatland_viz.world_files import label, title


@pytest.mark.parametrize(
    ("file", "name"),
    [("box.model.yaml", "box"), ("rover.yaml", "rover"), ("a.b.model.yaml", "a.b")],
)
def test_names_of_models_have_no_ending(file, name):
    assert label(Path("/worlds") / file) == name


def test_the_title_names_the_world_with_its_folder():
    assert title("/home/me/worlds/office/world.yaml") == "Flatland - office/world.yaml[*]"
    assert title("") == "Flatland[*]"
