"""Contacts that are kept after their hook: they can be compared, and not used otherwise."""

import pytest
from gone.keepers import kept

from flatland_server import _core

SETTINGS = ("friction", "restitution", "tangent_speed")
READS = ("touching", "enabled", "points", "normal", *SETTINGS)


@pytest.mark.parametrize("is_model_deleted", [False, True])
def test_a_contact_cannot_be_used_after_its_hook(world, simulate, is_model_deleted):
    simulate(world).run(0.1)
    contact = kept[0][1]
    if is_model_deleted:
        world.delete_model("robot")
    public = {name for name in dir(contact) if not name.startswith("_")}

    message = "a contact can be used only in the hook that it was given to"
    for name in READS:
        with pytest.raises(_core.GoneError, match=message):
            getattr(contact, name)
    for name in SETTINGS:
        with pytest.raises(_core.GoneError, match=message):
            setattr(contact, name, 1.0)
    with pytest.raises(_core.GoneError, match=message):
        contact.set_enabled(False)
    assert public == {*READS, "set_enabled", "fixture_a", "fixture_b"}


def test_a_kept_contact_can_be_compared_and_has_its_fixtures(world, simulate):
    simulate(world).run(0.1)

    contacts = [contact for _, contact, *_ in kept]
    robot, wall = world.get_model("robot"), world.layers[0]
    assert len(contacts) > 10
    assert set(contacts) == {contacts[0]}
    touching = {contacts[0].fixture_a.body, contacts[0].fixture_b.body}
    assert touching == {robot.base.physics_body, *wall.physics_bodies}


def test_impulses_and_manifolds_may_be_kept(world, simulate):
    simulate(world).run(0.1)
    details = [detail for _, _, *rest in kept for detail in rest]

    world.delete_model("robot")

    assert {type(detail) for detail in details} == {_core.Manifold, _core.ContactImpulse}
    assert all(len(detail.normal_impulses) in (0, 1) for detail in details)


def test_sides_of_a_kept_contact_end_with_its_body(world, simulate):
    simulate(world).run(0.1)
    keeper, contact, *_ = kept[0]
    assert keeper.filter_contact(contact).entity is world.layers[0]

    world.delete_model("robot")

    with pytest.raises(_core.GoneError, match="has been deleted"):
        keeper.filter_contact(contact)
