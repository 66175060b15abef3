"""Objects excluded from garbage collection; the server's objects are freed nevertheless."""

import atexit
import gc
import weakref
from pathlib import Path
from typing import Iterator

import pytest

from flatland2d.cli import main
from flatland_server.ros.server import exclude_from_garbage_collection
from flatland_server.simulation.world import World

OFFICE = Path(__file__).resolve().parents[2] / "worlds" / "office" / "world.yaml"


@pytest.fixture
def frozen_office() -> Iterator[World]:
    """The office, excluded from collection; automatic collection is off, for exact counts."""
    world = World.from_file(OFFICE)
    gc.disable()
    exclude_from_garbage_collection()
    yield world
    gc.unfreeze()
    gc.enable()
    world.close()
    del world
    gc.collect()
    gc.freeze()  # excludes the collected tests again, as the conftest.py at the top does


def test_a_collection_does_not_traverse_what_was_loaded(frozen_office):
    assert gc.get_freeze_count() > 50_000  # libraries, for the most part
    assert len(gc.get_objects()) < 1_000


@pytest.mark.parametrize("name", ["turtlebot", "box_1"])
def test_a_deleted_model_is_freed_without_a_collection(frozen_office, name):
    parts = [frozen_office.models[name], *frozen_office.contents.plugins.plugins_of(name)]
    references = [weakref.ref(part) for part in parts]
    parts.clear()

    frozen_office.delete_model(name)

    assert [reference() for reference in references] == [None] * len(references)


def test_a_command_collects_nothing_at_exit(monkeypatch):
    at_exit = []
    monkeypatch.setattr(atexit, "register", at_exit.append)

    assert main(["worlds"]) == 0

    assert gc.freeze in at_exit
