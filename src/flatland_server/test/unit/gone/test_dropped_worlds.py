"""A world without references is collected; parts of it that are kept can outlive it."""

import gc
import logging
import weakref

import pytest
from gone.keepers import ROBOT, kept, lean_on_wall

from flatland_server import _core


def test_a_body_and_a_contact_outlive_their_world(files, simulate, world):
    simulate(world).run(0.1)
    body, contact = world.get_model("robot").base.physics_body, kept[0][1]
    kept.clear()

    world.close()
    del world
    gc.collect()

    assert body.mass > 0.0
    with pytest.raises(_core.GoneError):
        _ = contact.points


@pytest.mark.parametrize("is_closed", [True, False])
def test_a_dropped_world_is_collected(files, simulate, caplog, is_closed):
    # The log records that pytest keeps have tracebacks, which refer to the world.
    caplog.set_level(logging.CRITICAL, "flatland_server.plugins.plugin_manager")
    world = lean_on_wall(files, ROBOT)
    simulate(world).run(0.1)
    assert len(world.plugin_failures) == 1
    if is_closed:
        world.close()
    traces = [weakref.ref(world), weakref.ref(world.physics)]
    traces += [weakref.ref(plugin) for plugin, *_ in kept]
    kept.clear()

    del world
    gc.collect()

    assert [trace() for trace in traces if trace() is not None] == []


def test_a_dropped_world_is_collected_after_an_interrupted_step(files, simulate):
    world = lean_on_wall(files, ROBOT.replace("Failing", "Keeper"))

    def interrupt(*_):
        raise KeyboardInterrupt

    world.physics.set_contact_listener(interrupt)
    with pytest.raises(KeyboardInterrupt):
        simulate(world).run(0.1)
    world.close()
    trace = weakref.ref(world.physics)

    del world
    gc.collect()

    assert trace() is None
