"""A world and its plugins: access to the world, failures, and the end of topics."""

from world.parts import EMPTY, Talker, spawn


def test_a_plugin_of_the_world_has_access_to_the_world(models, simulate, transport):
    text = f"{EMPTY}plugins: [{{type: Herald, name: herald}}]\n"
    world = models.load(text + "models: [{name: a, model: plain.yaml}]", transport=transport)
    spawn(models, world, "plain.yaml", "b")

    simulate(world).run()

    assert transport.last("/population") == 2


def test_a_closed_world_has_no_topics(models, transport):
    world = models.load(f"{EMPTY}models: [{{name: a, model: good.yaml}}]", transport=transport)

    world.close()

    assert (transport.topics, transport.subscribed) == (set(), set())


def test_a_world_lists_its_plugins_that_have_failed(models, simulate, monkeypatch):
    def fail(*_):
        raise ValueError("no luck")

    world = models.load(f"{EMPTY}plugins: [{{type: Herald, name: herald}}]\n")
    spawn(models, world, "good.yaml", "robot")
    assert world.plugin_failures == []
    monkeypatch.setattr(Talker, "after_physics_step", fail)
    spawn(models, world, "good.yaml", "other")

    simulate(world).run()

    [failure] = world.plugin_failures
    assert failure.label == "other/a"
    assert failure.type == "Talker"
    assert failure.reason == "after_physics_step: ValueError: no luck"
    assert world.transport.last("/population") == 2
