"""The contacts that the core reports, and their delivery to plugins: time and order."""

from typing import Any, Dict, List, Tuple

import numpy as np
import pytest
from contacts.room import BOUNCING, DISC, Room, actions, called_hooks, calls

from flatland_server import _core
from flatland_server.geometry import Pose


def reported_events(room: Room) -> List[Tuple[Any, ...]]:
    """The contact events that the core reports from now on, instead of to the plugins."""
    events: List[Tuple[Any, ...]] = []
    room.world.physics.set_contact_listener(lambda *event: events.append(event))
    return events


def test_the_hooks_of_a_step_are_called_in_their_order(room):
    room.put("ball", (0.5, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    timekeeper = room.simulation.timekeeper
    times = []
    actions["begin_contact"] = lambda *_: times.append(timekeeper.nanoseconds)

    room.run_until("begin_contact")
    hits = list(dict.fromkeys(called_hooks()))
    time_after = timekeeper.nanoseconds
    room.world.get_model("ball").base.physics_body.velocity = (-1.0, 0.0, 0.0)
    room.run_until("end_contact")

    contact_hooks = ["begin_contact", "pre_solve", "post_solve"]
    assert hits == ["before_physics_step", *contact_hooks, "after_physics_step"]
    assert times == [time_after - 5_000_000]
    assert called_hooks() == ["before_physics_step", "end_contact", "after_physics_step"]


def test_the_core_reports_only_events_with_overridden_hooks(room):
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "OnlyBegin")
    room.run(0.1)
    assert called_hooks() == ["begin_contact"]

    events = reported_events(room)
    room.world.get_model("ball").base.physics_body.velocity = (-1.0, 0.0, 0.0)
    room.run(0.1)
    room.world.get_model("ball").base.physics_body.velocity = (2.0, 0.0, 0.0)
    room.run(0.2)

    assert [event for event, *_ in events] == [_core.BEGIN_CONTACT]


@pytest.mark.parametrize("plugins", ["", "NoContactHooks"])
def test_models_without_contact_hooks_have_no_events(room, plugins):
    ball = room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), plugins)
    room.put("listener", (0.0, 3.0, 0.0), plugins="Listener")
    events = reported_events(room)

    room.run(0.2)

    assert ball.pose.x == pytest.approx(0.9, abs=0.01)  # it touches the wall
    assert events == []


def test_no_contacts_are_reported_after_the_only_listener_failed(room, caplog):
    def fail(*_):
        raise RuntimeError("no luck")

    actions["begin_contact"] = fail
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    assert len(room.world.plugin_failures) == 1
    calls.clear()
    events = reported_events(room)

    room.run(0.2)

    assert (events, calls) == ([], [])


def test_a_plugin_gets_only_the_contacts_of_its_own_model(room):
    room.put("a", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.put("b", (0.85, 2.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.put("c", (-1.0, 0.0, 0.0), plugins="Listener")

    room.run(0.1)

    begun = [(plugin, contact) for plugin, hook, *(contact, *_) in calls if hook == "begin_contact"]
    touched = [(plugin, c.fixture_a.body.id, c.fixture_b.body.id) for plugin, c in begun]
    a, b = (room.world.get_model(name).base.physics_body.id for name in "ab")
    wall = room.world.layers[0].physics_bodies[0].id
    assert {(plugin, *sorted(ids)) for plugin, *ids in touched} == {
        ("a/p0", *sorted([wall, a])),
        ("b/p0", *sorted([wall, b])),
    }


def test_plugins_of_both_models_get_a_contact_in_starting_order(room):
    left = room.put("left", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener | OnlyBegin | Listener")
    right = room.put("right", (0.3, 0.0, 0.0), (-1.0, 0.0, 0.0), "Listener")

    room.run_until("begin_contact")

    begun = [(plugin, contact) for plugin, hook, *(contact, *_) in calls if hook == "begin_contact"]
    assert [plugin for plugin, _ in begun] == ["left/p0", "left/p1", "left/p2", "right/p0"]
    assert len({contact for _, contact in begun}) == 1
    bodies = {begun[0][1].fixture_a.body, begun[0][1].fixture_b.body}
    assert bodies == {left.base.physics_body, right.base.physics_body}
    solved = [plugin for plugin, hook, *_ in calls if hook == "pre_solve"]
    assert solved[:3] == ["left/p0", "left/p2", "right/p0"]


def test_world_plugins_get_contacts_before_later_models_do(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: world}]")
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run_until("begin_contact")

    begun = [plugin for plugin, hook, *_ in calls if hook == "begin_contact"]
    assert begun == ["world", "ball/p0"]


def test_a_contact_within_a_model_is_reported_once(files, room):
    path = files.write(
        "pair.yaml",
        f"bodies:\n  - {{name: a, footprints: [{DISC}]}}\n"
        f"  - {{name: b, pose: [0.15, 0, 0], footprints: [{DISC}]}}\n"
        "plugins: [{type: Listener, name: p0}]\n",
    )
    sides = []
    actions["begin_contact"] = lambda plugin, contact: sides.append(plugin.filter_contact(contact))
    pair = room.world.spawn_model(path, "pair", "", Pose())

    room.run()

    [(entity, this, other)] = sides
    assert entity is pair
    assert {pair.body_name(this), pair.body_name(other)} == {"a", "b"}


def test_plugins_get_contacts_of_models_and_walls_added_later(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: world}]")
    room.put("early", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    assert called_hooks("world").count("begin_contact") == 1

    room.put("late", (0.85, 2.0, 0.0), (2.0, 0.0, 0.0), "NoContactHooks")
    room.run(0.1)
    assert called_hooks("world").count("begin_contact") == 2

    calls.clear()
    room.add_wall(-1.0, -5.0, -1.0, 5.0)
    foreign = room.world.physics.add_body("dynamic", (-0.5, -2.0, 0.0))  # of no model
    foreign.add_circle((0.0, 0.0), 0.1, density=1.0)
    foreign.velocity = (-2.0, 0.0, 0.0)
    room.world.get_model("early").base.physics_body.velocity = (-2.0, 0.0, 0.0)
    room.run(1.2)

    begun = [(plugin, c) for plugin, hook, *(c, *_) in calls if hook == "begin_contact"]
    new_wall = room.world.layers[0].physics_bodies[1]
    assert all(new_wall in (c.fixture_a.body, c.fixture_b.body) for _, c in begun)
    assert sorted(plugin for plugin, _ in begun) == ["early/p0", "world", "world"]


def test_a_contact_equals_itself_in_all_events_and_ends(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: world}]")
    for x1, y1, x2, y2 in ((1, 1, -1, 1), (-1, 1, -1, -1), (-1, -1, 1, -1)):
        room.add_wall(x1, y1, x2, y2)
    rng = np.random.default_rng(1)
    for i in range(12):
        place = (-0.75 + 0.5 * (i % 4), -0.6 + 0.5 * (i // 4), 0.0)
        room.put(f"ball{i}", place, (*rng.uniform(-3, 3, 2), 0.0), footprints=BOUNCING)
    going: Dict[Any, Any] = {}
    ended = []

    def begin(_, contact):
        assert contact not in going
        going[contact] = hash(contact), {contact.fixture_a, contact.fixture_b}

    def go_on(_, contact, __):
        assert going[contact] == (hash(contact), {contact.fixture_a, contact.fixture_b})

    def end(_, contact):
        ended.append(going.pop(contact))

    actions.update(begin_contact=begin, pre_solve=go_on, post_solve=go_on, end_contact=end)
    room.run(2.0)
    for name in list(room.world.models):
        room.world.delete_model(name)

    assert room.world.plugin_failures == []
    assert len(ended) > 50
    assert going == {}


def test_sensor_contacts_begin_and_end_but_are_not_solved(room):
    sensor = "{type: circle, radius: 0.1, density: 10, sensor: true}"
    room.put("ghost", (0.7, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener", sensor)
    seen = []
    actions["begin_contact"] = lambda _, c: seen.append((c.points, c.normal, c.touching))

    room.run(1.0)

    contact_hooks = [hook for hook in called_hooks() if "step" not in hook]
    assert contact_hooks == ["begin_contact", "end_contact"]
    assert seen == [([], (0.0, 0.0), True)]
