"""The list of worlds that were opened last."""

from flatland_viz.recent_worlds import names_of, with_recent


def test_the_present_world_comes_first_and_each_once():
    assert with_recent(["/a", "/b", "/c"], "/b") == ["/b", "/a", "/c"]
    assert with_recent([], "/a") == ["/a"]


def test_the_list_has_an_end():
    paths = [f"/{number}" for number in range(8)]

    assert with_recent(paths, "/new") == ["/new", *paths[:7]]


def test_names_tell_files_apart():
    paths = ["/x/office/world.yaml", "/y/office/world.yaml", "/x/room/world.yaml"]

    assert names_of(paths) == [*paths[:2], "room/world.yaml"]
