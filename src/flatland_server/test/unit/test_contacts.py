"""Contacts: which plugins hear of them, when and in what order, and what they can do about them."""

import math
from typing import Any, Callable, Dict, Iterator, List, Tuple

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.geometry import Pose
from flatland_server.model_plugin import ModelPlugin
from flatland_server.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.world_plugin import WorldPlugin

DT = 0.005
RADIUS = 0.1
MASS = 10.0 * math.pi * RADIUS**2  # kg
INERTIA = 0.5 * MASS * RADIUS**2  # kg m^2
DISC = f"{{type: circle, radius: {RADIUS}, density: 10}}"
BOUNCING = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: 1}}"
SQUARE = "{type: polygon, points: [[-.2, -.2], [.2, -.2], [.2, .2], [-.2, .2]], density: 10}"

CONTACT_HOOKS = ("begin_contact", "pre_solve", "post_solve", "end_contact")

calls: List[Tuple[Any, ...]] = []
"""What was called so far: (plugin, hook, what the hook was given ...)."""

deeds: Dict[str, Callable[..., None]] = {}
"""What plugins do in a hook, by its name; each is given the plugin and the hook's arguments."""


class _Hooks:
    """Notes its hooks, and does what the test wants."""

    def on_initialize(self, config):
        self.label = f"{self.model.name}/{self.name}" if hasattr(self, "model") else self.name

    def before_physics_step(self, *arguments):
        self._hook("before_physics_step", *arguments)

    def begin_contact(self, *arguments):
        self._hook("begin_contact", *arguments)

    def pre_solve(self, *arguments):
        self._hook("pre_solve", *arguments)

    def end_contact(self, *arguments):
        self._hook("end_contact", *arguments)

    def post_solve(self, *arguments):
        self._hook("post_solve", *arguments)

    def after_physics_step(self, *arguments):
        self._hook("after_physics_step", *arguments)

    def _hook(self, hook: str, *arguments: Any) -> None:
        calls.append((self.label, hook, *arguments))
        deeds.get(hook, lambda *_: None)(self, *arguments)


class Listener(_Hooks, ModelPlugin):
    pass


class WorldListener(_Hooks, WorldPlugin):
    pass


class OnlyBegin(ModelPlugin):
    def on_initialize(self, config):
        pass

    def begin_contact(self, contact):
        calls.append((f"{self.model.name}/{self.name}", "begin_contact", contact))


class Deaf(ModelPlugin):
    """Has hooks, but none of contacts."""

    def on_initialize(self, config):
        pass

    def before_physics_step(self, timekeeper):
        pass


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    yield
    calls.clear()
    deeds.clear()


@pytest.fixture(scope="module")
def loader() -> PluginLoader:
    """The plugins of this file."""
    classes = (Listener, WorldListener, OnlyBegin, Deaf)
    return PluginLoader(
        PluginDeclaration(c.__name__, "test", f"{__name__}.{c.__name__}") for c in classes
    )


class Room:
    """A world with a wall along x = 1, in which models are put in motion."""

    def __init__(self, files, simulate, plugins: str = "[]") -> None:
        self._files = files
        text = f"properties: {{}}\nlayers: [{{name: walls}}]\nplugins: {plugins}\n"
        self.world = files.load(text)
        self.simulation = simulate(self.world, DT)
        self.add_wall(1.0, -5.0, 1.0, 5.0)

    def add_wall(self, *ends: float) -> None:
        self.world.add_walls("walls", np.array([ends]))

    def put(self, name: str, pose, velocity=(0.0, 0.0, 0.0), plugins="", footprints=DISC):
        """Spawns a model of one body, "base"; plugins are given as "type | type"."""
        entries = "".join(
            f"\n  - {{type: {type.strip()}, name: p{i}}}"
            for i, type in enumerate(plugins.split("|"))
            if type.strip()
        )
        bodies = f"bodies: [{{name: base, footprints: [{footprints}]}}]\n"
        path = self._files.write(f"{name}.yaml", f"{bodies}plugins:{entries or ' []'}\n")
        model = self.world.spawn_model(path, name, "", Pose(*pose))
        model.base.physics_body.velocity = velocity
        return model

    def run(self, seconds=None):
        self.simulation.run(seconds)

    def run_until(self, hook: str) -> None:
        """Steps until a hook is called, and to the end of that step."""
        for _ in range(1000):
            calls.clear()
            self.run()
            if hook in heard():
                return
        raise AssertionError(f"{hook} is never called")


@pytest.fixture
def room(files, simulate) -> Room:
    return Room(files, simulate)


def heard(label: str = "") -> List[str]:
    """The hooks that were called so far, of one plugin or of all."""
    return [hook for who, hook, *_ in calls if label in ("", who)]


def told(room: Room) -> List[Tuple[Any, ...]]:
    """What the core tells Python of contacts from now on; the plugins do not hear it."""
    events: List[Tuple[Any, ...]] = []
    room.world.physics.set_contact_listener(lambda *event: events.append(event))
    return events


# Who hears of what, and when


def test_the_hooks_of_a_step_come_in_their_order(room):
    room.put("ball", (0.5, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    timekeeper = room.simulation.timekeeper
    times = []
    deeds["begin_contact"] = lambda *_: times.append(timekeeper.nanoseconds)

    room.run_until("begin_contact")
    hits = list(dict.fromkeys(heard()))
    time_after = timekeeper.nanoseconds
    room.world.get_model("ball").base.physics_body.velocity = (-1.0, 0.0, 0.0)
    room.run_until("end_contact")

    contact_hooks = ["begin_contact", "pre_solve", "post_solve"]
    assert hits == ["before_physics_step", *contact_hooks, "after_physics_step"]
    assert times == [time_after - 5_000_000]
    assert heard() == ["before_physics_step", "end_contact", "after_physics_step"]


def test_only_hooks_that_are_overridden_are_called_and_only_those_are_told_of(room):
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "OnlyBegin")
    room.run(0.1)
    assert heard() == ["begin_contact"]

    events = told(room)
    room.world.get_model("ball").base.physics_body.velocity = (-1.0, 0.0, 0.0)
    room.run(0.1)
    room.world.get_model("ball").base.physics_body.velocity = (2.0, 0.0, 0.0)
    room.run(0.2)

    assert [moment for moment, *_ in events] == [_core.BEGIN_CONTACT]


@pytest.mark.parametrize("plugins", ["", "Deaf"])
def test_contacts_of_a_model_without_contact_hooks_never_reach_python(room, plugins):
    ball = room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), plugins)
    room.put("listener", (0.0, 3.0, 0.0), plugins="Listener")
    events = told(room)

    room.run(0.2)

    assert ball.pose.x == pytest.approx(0.9, abs=0.01)  # it does touch the wall
    assert events == []


def test_contacts_of_a_model_reach_python_no_more_when_its_listener_has_failed(room, caplog):
    def fail(*_):
        raise RuntimeError("no luck")

    deeds["begin_contact"] = fail
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    assert len(room.world.plugin_failures) == 1
    calls.clear()
    events = told(room)

    room.run(0.2)

    assert (events, calls) == ([], [])


def test_a_plugin_hears_of_its_own_models_contacts_alone(room):
    room.put("a", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.put("b", (0.85, 2.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.put("c", (-1.0, 0.0, 0.0), plugins="Listener")

    room.run(0.1)

    begun = [(who, contact) for who, hook, *(contact, *_) in calls if hook == "begin_contact"]
    touched = [(who, c.fixture_a.body.id, c.fixture_b.body.id) for who, c in begun]
    a, b = (room.world.get_model(name).base.physics_body.id for name in "ab")
    wall = room.world.layers[0].physics_bodies[0].id
    assert {(who, *sorted(ids)) for who, *ids in touched} == {
        ("a/p0", *sorted([wall, a])),
        ("b/p0", *sorted([wall, b])),
    }


def test_of_two_models_that_touch_both_hear_in_the_order_in_which_they_were_started(room):
    left = room.put("left", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener | OnlyBegin | Listener")
    right = room.put("right", (0.3, 0.0, 0.0), (-1.0, 0.0, 0.0), "Listener")

    room.run_until("begin_contact")

    begun = [(who, contact) for who, hook, *(contact, *_) in calls if hook == "begin_contact"]
    assert [who for who, _ in begun] == ["left/p0", "left/p1", "left/p2", "right/p0"]
    assert len({contact for _, contact in begun}) == 1
    bodies = {begun[0][1].fixture_a.body, begun[0][1].fixture_b.body}
    assert bodies == {left.base.physics_body, right.base.physics_body}
    solved = [who for who, hook, *_ in calls if hook == "pre_solve"]
    assert solved[:3] == ["left/p0", "left/p2", "right/p0"]


def test_a_plugin_of_the_world_hears_before_the_models_that_came_after_it(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: ear}]")
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run_until("begin_contact")

    begun = [who for who, hook, *_ in calls if hook == "begin_contact"]
    assert begun == ["ear", "ball/p0"]


def test_a_contact_within_a_model_is_told_to_its_plugins_once(files, room):
    path = files.write(
        "pair.yaml",
        f"bodies:\n  - {{name: a, footprints: [{DISC}]}}\n"
        f"  - {{name: b, pose: [0.15, 0, 0], footprints: [{DISC}]}}\n"
        "plugins: [{type: Listener, name: p0}]\n",
    )
    sides = []
    deeds["begin_contact"] = lambda plugin, contact: sides.append(plugin.filter_contact(contact))
    pair = room.world.spawn_model(path, "pair", "", Pose())

    room.run()

    [(entity, this, other)] = sides
    assert entity is pair
    assert {pair.body_name(this), pair.body_name(other)} == {"a", "b"}


def test_plugins_of_the_world_hear_of_all_contacts_also_of_what_came_later(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: ear}]")
    room.put("early", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0))
    room.run(0.1)
    assert heard("ear").count("begin_contact") == 1

    room.put("late", (0.85, 2.0, 0.0), (2.0, 0.0, 0.0), "Deaf")
    room.run(0.1)
    assert heard("ear").count("begin_contact") == 2

    calls.clear()
    room.add_wall(-1.0, -5.0, -1.0, 5.0)
    room.world.get_model("early").base.physics_body.velocity = (-2.0, 0.0, 0.0)
    room.run(1.2)
    pairs = [contact for _, hook, *(contact, *_) in calls if hook == "begin_contact"]
    new_wall = room.world.layers[0].physics_bodies[1]
    assert [new_wall in (c.fixture_a.body, c.fixture_b.body) for c in pairs] == [True]


def test_a_model_with_a_listener_hears_of_a_wall_that_was_put_up_later(room):
    room.put("ball", (0.0, 0.0, 0.0), (-2.0, 0.0, 0.0), "Listener")
    room.add_wall(-0.5, -5.0, -0.5, 5.0)

    room.run(0.4)

    assert heard().count("begin_contact") == 1


def test_a_contact_is_equal_from_its_begin_to_its_end_and_every_begin_has_an_end(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: ear}]")
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

    deeds.update(begin_contact=begin, pre_solve=go_on, post_solve=go_on, end_contact=end)
    room.run(2.0)
    for name in list(room.world.models):
        room.world.delete_model(name)

    assert room.world.plugin_failures == []
    assert len(ended) > 50
    assert going == {}


def test_a_sensor_is_told_of_but_never_solved(room):
    sensor = "{type: circle, radius: 0.1, density: 10, sensor: true}"
    room.put("ghost", (0.7, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener", sensor)
    seen = []
    deeds["begin_contact"] = lambda _, c: seen.append((c.points, c.normal, c.touching))

    room.run(1.0)

    contact_hooks = [hook for hook in heard() if "step" not in hook]
    assert contact_hooks == ["begin_contact", "end_contact"]
    assert seen == [([], (0.0, 0.0), True)]


# What a hook is given


def test_a_contact_with_a_wall_names_the_layer_and_the_fixtures_of_both(room):
    room.add_wall(-1.0, -5.0, -1.0, 5.0)
    both = f"{{type: circle, radius: 0.05, density: 1, center: [-0.3, 0]}}, {DISC}"
    ball = room.put("ball", (0.5, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", both)
    sides = []
    deeds["begin_contact"] = lambda plugin, contact: sides.append(plugin.filter_contact(contact))

    room.run(0.5)
    ball.base.physics_body.velocity = (-2.0, 0.0, 0.0)
    room.run(0.8)

    layer = room.world.layers[0]
    front, rear = ball.base.physics_body.fixtures[1], ball.base.physics_body.fixtures[0]
    first, second = layer.physics_bodies
    assert [(s.entity, s.this_fixture, s.other_fixture.body) for s in sides] == [
        (layer, front, first),
        (layer, rear, second),
    ]
    assert [s.this_fixture.index for s in sides] == [1, 0]
    assert [ball.config.bodies[0].footprints[s.this_fixture.index].density for s in sides] == [
        10,
        1,
    ]
    assert [s.entity.body_name(s.other_fixture) for s in sides] == ["walls", "walls"]
    assert [ball.body_name(s.this_fixture) for s in sides] == ["base", "base"]


def test_a_walls_fixture_tells_which_of_the_segments_it_is(room):
    room.world.add_walls("walls", np.array([[5, 0, 6, 0], [-1, -5, -1, 5], [5, 1, 6, 1]]))
    room.put("ball", (0.0, 0.0, 0.0), (-2.0, 0.0, 0.0), "Listener")
    indices = []
    deeds["begin_contact"] = lambda plugin, contact: indices.append(
        plugin.filter_contact(contact).other_fixture.index
    )

    room.run(0.6)

    assert indices == [1]


def test_each_of_two_models_has_the_contact_from_its_own_side(room):
    models = {
        name: room.put(name, (x, 0.0, 0.0), (vx, 0.0, 0.0), "Listener")
        for name, x, vx in (("left", 0.0, 1.0), ("right", 0.4, -1.0))
    }
    sides, normals = {}, {}

    def begin(plugin, contact):
        sides[plugin.model.name] = plugin.filter_contact(contact)

    def solve(plugin, contact, _):
        a, b = (fixture.body.pose for fixture in (contact.fixture_a, contact.fixture_b))
        normals[plugin.model.name] = contact.normal, math.copysign(1.0, b[0] - a[0])

    deeds.update(begin_contact=begin, pre_solve=solve)
    room.run(0.3)

    for name, other in (("left", "right"), ("right", "left")):
        assert sides[name].entity is models[other]
        assert sides[name].this_fixture.body == models[name].base.physics_body
        assert sides[name].other_fixture.body == models[other].base.physics_body
        normal, towards_b = normals[name]
        assert normal == pytest.approx((towards_b, 0.0), abs=1e-6)


def test_a_model_has_no_side_in_a_contact_of_others(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: ear}]")
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.put("bystander", (0.0, 0.0, 0.0), plugins="Listener")
    plugins = {}
    deeds["before_physics_step"] = lambda plugin, _: plugins.update({plugin.label: plugin})
    sides = []

    def begin(plugin, contact):
        if plugin.label == "ear":
            sides.append(plugins["bystander/p0"].filter_contact(contact))

    deeds["begin_contact"] = begin
    room.run(0.1)

    assert sides == [None]


def test_plugins_of_the_world_hear_of_all_that_touches_a_wall_that_came_later(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: ear}]")
    foreign = room.world.physics.add_body("dynamic", (-0.5, 0.0, 0.0))
    foreign.add_circle((0.0, 0.0), 0.1, density=1.0)
    foreign.velocity = (-1.0, 0.0, 0.0)

    room.add_wall(-1.0, -5.0, -1.0, 5.0)
    room.run(0.5)

    assert heard("ear").count("begin_contact") == 1


def test_a_body_that_is_nobodys_is_felt_but_has_no_entity(room, caplog):
    """A plugin may have made it for itself."""
    room.put("ball", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener | OnlyBegin")
    foreign = room.world.physics.add_body("static", (0.5, 0.0, 0.0))
    foreign.add_circle((0.0, 0.0), 0.1, density=1.0)
    deeds["begin_contact"] = lambda plugin, contact: plugin.filter_contact(contact)

    room.run(0.5)

    assert heard("ball/p1") == ["begin_contact"]
    [failure] = room.world.plugin_failures
    assert failure.label == "ball/p0"
    assert failure.reason.endswith("this body has been deleted, or is of no model or layer")


def test_the_points_of_a_contact_lie_where_the_two_touch(room):
    room.put("square", (0.7, 0.5, 0.0), (2.0, 0.0, 0.0), "Listener", SQUARE)
    points, normals = [], []
    deeds["post_solve"] = lambda _, contact, __: points.append(contact.points)
    deeds["begin_contact"] = lambda _, contact: normals.append(contact.normal)

    room.run(0.2)

    assert sorted(y for _, y in points[-1]) == pytest.approx([0.3, 0.7], abs=1e-3)
    assert [x for x, _ in points[-1]] == pytest.approx([1.0, 1.0], abs=0.01)
    assert normals[0] == pytest.approx((-1.0, 0.0)) or normals[0] == pytest.approx((1.0, 0.0))


# What can be done about a contact, and within its hooks


@pytest.mark.parametrize("speed", [1.0, 20.0, 100.0])
def test_a_body_passes_through_a_wall_if_its_contact_is_switched_off(room, speed):
    deeds["pre_solve"] = lambda _, contact, __: contact.set_enabled(False)
    ball = room.put("ball", (0.85, 0.0, 0.0), (speed, 0.0, 0.0), "Listener")

    room.run(0.5)

    assert "pre_solve" in heard()
    assert ball.pose.x == pytest.approx(0.85 + 0.5 * speed, rel=1e-5)
    assert ball.base.physics_body.velocity == pytest.approx((speed, 0.0, 0.0))


def test_a_body_that_leaves_its_contacts_on_is_stopped_by_the_wall(room):
    ball = room.put("ball", (0.85, 0.0, 0.0), (20.0, 0.0, 0.0), "Listener")

    room.run(0.5)

    assert ball.pose.x == pytest.approx(1.0 - RADIUS, abs=0.01)


def test_two_models_pass_through_each_other_if_one_of_them_wants_it(room):
    def let_pass(plugin, contact, _):
        contact.set_enabled(plugin.model.name != "ghost" and contact.enabled)

    deeds["pre_solve"] = let_pass
    ghost = room.put("ghost", (0.0, 0.0, 0.0), (0.5, 0.0, 0.0), "Listener")
    other = room.put("other", (0.3, 0.0, 0.0), (0.0, 0.0, 0.0), "Listener")

    room.run(1.0)

    assert ghost.pose == pytest.approx((0.5, 0.0, 0.0), abs=1e-5)
    assert other.pose == pytest.approx((0.3, 0.0, 0.0), abs=1e-6)


def test_a_contact_is_switched_off_for_one_step_only(room):
    deeds["pre_solve"] = lambda _, contact, __: contact.set_enabled(False)
    ball = room.put("ball", (0.85, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    assert ball.pose.x == pytest.approx(0.95)

    del deeds["pre_solve"]
    room.run(0.5)

    assert ball.pose.x < 0.91  # pushed out again


@pytest.mark.parametrize("hook", ["begin_contact", "end_contact", "post_solve"])
def test_a_contact_is_not_switched_in_another_hook(room, hook, caplog):
    deeds[hook] = lambda _, contact, *__: contact.set_enabled(False)
    ball = room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.run(0.1)
    ball.base.physics_body.velocity = (-1.0, 0.0, 0.0)
    room.run(0.1)

    [failure] = room.world.plugin_failures
    assert failure.reason == (
        f"{hook}: RuntimeError: a contact is switched on or off in pre_solve alone"
    )


@pytest.mark.parametrize(("restitution", "factor"), [(0.0, 1.0), (0.5, 1.5), (1.0, 2.0)])
def test_the_impulses_of_a_collision_are_the_momentum_it_changes(room, restitution, factor):
    impulses = []
    deeds["post_solve"] = lambda _, __, impulse: impulses.extend(impulse.normal_impulses)
    disc = f"{{type: circle, radius: {RADIUS}, density: 10, restitution: {restitution}}}"
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", disc)

    room.run(0.2)

    assert ball.base.physics_body.mass == pytest.approx(MASS)
    assert ball.base.physics_body.velocity[0] == pytest.approx(-2.0 * restitution, abs=1e-5)
    assert sum(impulses) == pytest.approx(factor * MASS * 2.0, rel=1e-5)


def test_two_models_share_the_impulse_of_their_collision(room):
    impulses: Dict[str, List[float]] = {"left/p0": [], "right/p0": []}
    deeds["post_solve"] = lambda plugin, _, impulse: impulses[plugin.label].extend(
        impulse.normal_impulses
    )
    room.put("left", (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    right = room.put("right", (0.3, 0.0, 0.0), (0.0, 0.0, 0.0), "Listener")

    room.run(0.2)

    assert right.base.physics_body.velocity[0] == pytest.approx(1.0, rel=1e-5)  # they stick
    assert sum(impulses["left/p0"]) == pytest.approx(MASS * 1.0, rel=1e-5)
    assert impulses["right/p0"] == impulses["left/p0"]


def test_the_old_manifold_has_the_points_and_impulses_of_the_step_before(room):
    force = 3.0
    solved, old = [], []
    deeds["before_physics_step"] = lambda plugin, _: plugin.model.base.physics_body.apply_force(
        (force, 0.0)
    )
    deeds["pre_solve"] = lambda _, __, manifold: old.append(manifold)
    deeds["post_solve"] = lambda _, __, impulse: solved.append(impulse)
    room.put("square", (0.79, 0.0, 0.0), plugins="Listener", footprints=SQUARE)

    room.run(1.0)

    assert old[0].local_points == []
    assert old[0].normal_impulses == []
    assert len(old[-1].local_points) == 2
    assert sum(solved[-1].normal_impulses) == pytest.approx(force * DT, rel=1e-3)
    assert sum(old[-1].normal_impulses) == pytest.approx(force * DT, rel=1e-3)
    assert old[-1].tangent_impulses == pytest.approx([0.0, 0.0], abs=1e-6)


def test_friction_that_is_set_before_solving_brakes_a_sliding_body(room):
    force, friction = 20.0, 0.5
    mass = 10.0 * 0.4**2
    square = room.put("square", (0.795, -3.0, 0.0), (0.0, 0.0, 0.0), "Listener", SQUARE)
    body = square.base.physics_body
    deeds["before_physics_step"] = lambda *_: body.apply_force((force, 0.0))
    room.run(0.1)
    body.velocity = (0.0, 4.0, 0.0)
    room.run(0.1)
    assert body.velocity[1] == pytest.approx(4.0, abs=1e-4)  # no footprint has any friction

    def rub(_, contact, __):
        contact.friction = friction

    deeds["pre_solve"] = rub
    room.run(0.4)

    assert body.velocity[1] == pytest.approx(4.0 - 0.4 * friction * force / mass, rel=0.01)


def test_restitution_that_is_set_before_solving_throws_a_body_back(room):
    def bounce(_, contact, __):
        contact.restitution = 0.75

    deeds["pre_solve"] = bounce
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run(0.2)

    assert ball.base.physics_body.velocity[0] == pytest.approx(-1.5, rel=1e-5)


@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_a_wall_with_a_tangent_speed_carries_along_what_leans_on_it(room, speed):
    directions = []

    def convey(plugin, contact, _):
        contact.friction = 1.0
        contact.tangent_speed = speed
        # Box2D: the velocity of b against a, along the normal turned by a quarter clockwise.
        side = 1.0 if contact.fixture_b.body == plugin.model.base.physics_body else -1.0
        directions.append(-side * contact.normal[0])

    deeds["pre_solve"] = convey
    square = room.put("square", (0.795, 0.0, 0.0), (0.0, 0.0, 0.0), "Listener", SQUARE)
    body = square.base.physics_body
    deeds["before_physics_step"] = lambda *_: body.apply_force((10.0, 0.0))

    room.run(0.5)

    assert body.velocity == pytest.approx((0.0, directions[-1] * speed, 0.0), abs=1e-3)


@pytest.mark.parametrize("name", ["friction", "restitution", "tangent_speed"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_contact_takes_no_value_that_is_none(room, name, value):
    refusals = []

    def spoil(_, contact, __):
        before = getattr(contact, name)
        try:
            setattr(contact, name, value)
        except ValueError as error:
            refusals.append(str(error))
        assert getattr(contact, name) == before

    deeds["pre_solve"] = spoil
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run(0.1)

    assert room.world.plugin_failures == []
    assert "must be finite" in refusals[0] or "must be" in refusals[0]


def test_a_velocity_that_is_set_as_two_touch_is_the_one_they_go_on_with(room):
    def turn_back(plugin, _):
        plugin.model.base.physics_body.velocity = (-3.0, 0.0, 0.0)

    deeds["begin_contact"] = turn_back
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")

    room.run(0.2)

    assert ball.base.physics_body.velocity == pytest.approx((-3.0, 0.0, 0.0))
    assert heard().count("begin_contact") == heard().count("end_contact") == 1


PUSHES = [
    pytest.param(
        lambda body: body.apply_linear_impulse((0.0, 0.5)), (0.5 / MASS, 0.0), id="impulse"
    ),
    pytest.param(
        lambda body: body.apply_angular_impulse(0.001), (0.0, 0.001 / INERTIA), id="angular impulse"
    ),
]
FORCES = [
    pytest.param(lambda body: body.apply_force((0.0, 0.5 / DT)), (0.5 / MASS, 0.0), id="force"),
    pytest.param(lambda body: body.apply_torque(0.001 / DT), (0.0, 0.001 / INERTIA), id="torque"),
]


def velocity_after_a_push(room: Room, hook: str, push: Callable[[_core.Body], None]) -> List[float]:
    """Along the wall [m/s], and the spin [rad/s], of a disc pushed once as it bounces off."""

    def push_once(plugin, *_):
        push(plugin.model.base.physics_body)
        del deeds[hook]

    deeds[hook] = push_once
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", BOUNCING)
    room.run(0.2)
    assert room.world.plugin_failures == []
    assert deeds == {}
    return list(ball.base.physics_body.velocity[1:])


@pytest.mark.parametrize(("push", "expected"), PUSHES)
@pytest.mark.parametrize("hook", CONTACT_HOOKS)
def test_impulses_act_from_within_the_hooks_of_contacts(room, hook, push, expected):
    assert velocity_after_a_push(room, hook, push) == pytest.approx(expected, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize(("push", "expected"), FORCES)
@pytest.mark.parametrize("hook", ["begin_contact", "pre_solve", "end_contact"])
def test_forces_act_from_within_the_hooks_before_a_step_is_solved(room, hook, push, expected):
    assert velocity_after_a_push(room, hook, push) == pytest.approx(expected, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("hook", CONTACT_HOOKS)
@pytest.mark.parametrize(
    "deed",
    [
        pytest.param(lambda m, b: setattr(b, "pose", (0.0, 0.0, 0.0)), id="place a body"),
        pytest.param(lambda m, b: m.move(Pose()), id="place a model"),
        pytest.param(lambda m, b: b.remove(), id="remove a body"),
        pytest.param(lambda m, b: m.physics.add_body("dynamic", (0, 0, 0)), id="add a body"),
        pytest.param(lambda m, b: m.physics.add_layer(np.eye(1, 4), 1), id="add walls"),
        pytest.param(lambda m, b: b.add_circle((0, 0), 1.0, density=1.0), id="add a fixture"),
        pytest.param(lambda m, b: b.add_drive(), id="add a drive"),
        pytest.param(lambda m, b: b.add_tween((1, 0, 0), 1.0), id="add a tween"),
        pytest.param(lambda m, b: m.physics.set_contact_listener(None), id="change the listener"),
        pytest.param(lambda m, b: m.physics.step(DT), id="step"),
    ],
)
def test_what_must_wait_for_the_end_of_the_step_switches_off_only_the_plugin_that_tries_it(
    room, hook, deed, caplog
):
    def try_it(plugin, *_):
        if plugin.label == "bad/p0":
            deed(plugin.model, plugin.model.base.physics_body)

    deeds[hook] = try_it
    for name, y in (("bad", 0.0), ("good", 2.0)):
        room.put(name, (0.8, y, 0.0), (2.0, 0.0, 0.0), "Listener", BOUNCING)
    room.run(0.2)

    [failure] = room.world.plugin_failures
    assert (failure.owner, failure.name) == ("bad", "p0")
    assert failure.reason.startswith(f"{hook}: RuntimeError: ")
    assert failure.reason.endswith("wait for the end of the step")
    assert heard("bad/p0")[-1] == hook
    assert heard("good/p0")[-1] == "after_physics_step"
    bad = room.world.get_model("bad").base.physics_body
    assert bad.velocity == pytest.approx((-2.0, 0.0, 0.0))  # it went on as it was
    assert room.world.physics.body_count == 3


@pytest.mark.parametrize("hook", CONTACT_HOOKS)
def test_an_interrupt_in_a_hook_ends_the_step_and_the_world_is_usable_afterwards(room, hook):
    def interrupt(*_):
        del deeds[hook]
        raise KeyboardInterrupt

    deeds[hook] = interrupt
    ball = room.put("ball", (0.8, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", BOUNCING)

    with pytest.raises(KeyboardInterrupt):
        room.run(0.2)

    assert room.world.plugin_failures == []
    ball.base.physics_body.velocity = (2.0, 0.0, 0.0)
    room.world.move_model("ball", Pose(0.5, 0.0, 0.0))
    room.run()  # leaves the contact that it may have had
    calls.clear()
    ball.base.physics_body.velocity = (2.0, 0.0, 0.0)
    room.run(0.3)
    assert [hook for hook in dict.fromkeys(heard()) if "step" not in hook] == list(CONTACT_HOOKS)
    room.world.delete_model("ball")
    assert room.world.physics.body_count == 1
