"""The names of the worlds that were opened last."""

from flatland_viz.world_menu import names_of


def test_names_tell_files_apart():
    paths = ["/x/office/world.yaml", "/y/office/world.yaml", "/x/room/world.yaml"]

    assert names_of(paths) == [*paths[:2], "room/world.yaml"]
