"""Crowd: people as models of the world, which can be moved, deleted and replaced."""

import logging
from typing import Any

import pytest
from townspeople import TOWARDS_EACH_OTHER, position

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.simulation.world import World


def test_people_are_models_named_after_their_crowd_or_themselves(town):
    anna = "pose: [2, 3, 0], name: anna, legs: true, radius: 0.35"
    people = town("pose: [1, 2, 0.5]", anna, "pose: [5, 5, 0]")

    assert list(people.world.models) == ["people_0", "anna", "people_2"]
    assert people.model("people_0").pose == pytest.approx((1.0, 2.0, 0.5))
    assert list(people.model("people_0").bodies) == ["body"]
    assert list(people.model("anna").bodies) == ["body", "left_leg", "right_leg"]
    masses = [people.model(name).base.physics_body.mass for name in people.world.models]
    assert masses == pytest.approx([80.0] * 3, rel=1e-5)  # whatever their size


def test_a_deleted_person_leaves_the_crowd_as_the_others_walk_on(town, caplog):
    people = town(*TOWARDS_EACH_OTHER, "pose: [0, 5, 0], goals: [[9, 5]]").run(1.0)
    bodies = people.world.physics.body_count

    people.world.delete_model("people_1")
    people.run(6.0)

    assert list(people.world.models) == ["people_0", "people_2"]
    assert people.world.physics.body_count == bodies - 1
    assert position(people)[0] > 3.7
    assert position(people, "people_2")[0] > 6.0
    assert len(people.last("/people/poses").poses) == 2
    assert not [r for r in caplog.records if r.levelno >= logging.WARNING]


def test_a_model_that_takes_a_name_over_is_not_one_of_them(town, files):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]").run(0.5)

    people.world.delete_model("people_0")
    path = files.folder / files.model("guest")
    people.world.spawn_model(path, "people_0", "", Pose(3.0, 0.0, 0.0))
    people.run(2.0)

    assert position(people) == pytest.approx((3.0, 0.0), abs=1e-6)
    assert people.last("/people/poses").poses == []
    people.world.close()
    assert list(people.world.models) == ["people_0"]  # and stays when the crowd ends


def test_a_moved_person_walks_on_from_there(town):
    people = town("pose: [0, 0, 0], goals: [[9, 0]], legs: true").run(1.0)

    people.world.move_model("people_0", Pose(9.0, 5.0, 2.0))
    people.run(0.1)
    assert position(people) == pytest.approx((9.0, 5.0), abs=0.05)
    people.run(8.0)

    assert position(people) == pytest.approx((9.0, 0.0), abs=0.05)


def test_people_go_when_their_crowd_fails(town, monkeypatch, caplog):
    people = town("pose: [0, 0, 0], goals: [[9, 0]]").run(0.5)

    def fail(*_: Any) -> None:
        raise RuntimeError("no luck")

    monkeypatch.setattr("flatland_plugins.crowd.fill_pose", fail)
    people.allow_failures = True
    people.run(0.1)

    assert people.world.models == {}
    assert "failed in before_physics_step" in caplog.text


def test_a_crowd_comes_wholly_or_not_at_all(town, monkeypatch):
    worlds = []

    def add_two(world: World, entry: Any) -> Any:
        worlds.append(world)
        if len(worlds) > 2:
            raise FlatlandError("no room for three")
        return add_model(world, entry)

    add_model = World.add_model
    monkeypatch.setattr(World, "add_model", add_two)

    with pytest.raises(FlatlandError, match="no room for three"):
        town("pose: [0, 0, 0]", "pose: [2, 0, 0], legs: true", "pose: [4, 0, 0]")

    assert worlds[0].models == {}
    assert worlds[0].physics.body_count == 0
    assert worlds[0].transport.topics == set()


def test_people_with_legs_may_be_updated_once_only(town):
    people = town("pose: [0, 0, 0], goals: [[9, 0]], legs: true", keys="update_rate: 1.0e-300")

    people.run(1.0)

    assert 0.0 < position(people)[0] < 9.0
