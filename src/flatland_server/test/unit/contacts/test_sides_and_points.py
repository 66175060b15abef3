"""The data that contact hooks get: the touching fixtures, their sides, and the points."""

import math

import numpy as np
import pytest
from contacts.room import DISC, SQUARE, Room, actions, called_hooks


def test_filter_contact_gives_layer_and_both_fixtures(room):
    room.add_wall(-1.0, -5.0, -1.0, 5.0)
    both = f"{{type: circle, radius: 0.05, density: 1, center: [-0.3, 0]}}, {DISC}"
    ball = room.put("ball", (0.5, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener", both)
    sides = []
    actions["begin_contact"] = lambda plugin, contact: sides.append(plugin.filter_contact(contact))

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
    footprints = ball.config.bodies[0].footprints
    assert [footprints[s.this_fixture.index].density for s in sides] == [10, 1]
    names = {(s.entity.body_name(s.other_fixture), ball.body_name(s.this_fixture)) for s in sides}
    assert names == {("walls", "base")}


def test_the_index_of_a_walls_fixture_is_that_of_its_segment(room):
    room.world.add_walls("walls", np.array([[5, 0, 6, 0], [-1, -5, -1, 5], [5, 1, 6, 1]]))
    room.put("ball", (0.0, 0.0, 0.0), (-2.0, 0.0, 0.0), "Listener")
    indices = []
    actions["begin_contact"] = lambda plugin, contact: indices.append(
        plugin.filter_contact(contact).other_fixture.index
    )

    room.run(0.6)

    assert indices == [1]


def test_each_of_two_models_gets_the_contact_from_its_own_side(room):
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

    actions.update(begin_contact=begin, pre_solve=solve)
    room.run(0.3)

    for name, other in (("left", "right"), ("right", "left")):
        assert sides[name].entity is models[other]
        assert sides[name].this_fixture.body == models[name].base.physics_body
        assert sides[name].other_fixture.body == models[other].base.physics_body
        normal, towards_b = normals[name]
        assert normal == pytest.approx((towards_b, 0.0), abs=1e-6)


def test_a_model_has_no_side_in_a_contact_of_other_models(files, simulate):
    room = Room(files, simulate, "[{type: WorldListener, name: world}]")
    room.put("ball", (0.85, 0.0, 0.0), (2.0, 0.0, 0.0), "Listener")
    room.put("bystander", (0.0, 0.0, 0.0), plugins="Listener")
    plugins = {}
    actions["before_physics_step"] = lambda plugin, _: plugins.update({plugin.label: plugin})
    sides = []

    def begin(plugin, contact):
        if plugin.label == "world":
            sides.append(plugins["bystander/p0"].filter_contact(contact))

    actions["begin_contact"] = begin
    room.run(0.1)

    assert sides == [None]


def test_a_body_without_an_entity_has_contacts_but_no_sides(room, caplog):
    """Plugins may add such bodies for their own use."""
    room.put("ball", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "Listener | OnlyBegin")
    foreign = room.world.physics.add_body("static", (0.5, 0.0, 0.0))
    foreign.add_circle((0.0, 0.0), 0.1, density=1.0)
    sides = []
    actions["begin_contact"] = lambda plugin, contact: sides.append(plugin.filter_contact(contact))

    room.run(0.5)

    assert called_hooks("ball/p1") == ["begin_contact"]
    assert sides == [None]
    assert room.world.plugin_failures == []


def test_the_points_of_a_contact_lie_where_the_two_touch(room):
    room.put("square", (0.7, 0.5, 0.0), (2.0, 0.0, 0.0), "Listener", SQUARE)
    points, normals = [], []
    actions["post_solve"] = lambda _, contact, __: points.append(contact.points)
    actions["begin_contact"] = lambda _, contact: normals.append(contact.normal)

    room.run(0.2)

    assert sorted(y for _, y in points[-1]) == pytest.approx([0.3, 0.7], abs=1e-3)
    assert [x for x, _ in points[-1]] == pytest.approx([1.0, 1.0], abs=0.01)
    assert normals[0] == pytest.approx((-1.0, 0.0)) or normals[0] == pytest.approx((1.0, 0.0))
