"""The calls of plugins' hooks: their times and their order; the random numbers of plugins."""

from plugin_manager.recorders import calls, step, world_of

from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_rng import _stream


def test_plugins_are_called_in_file_order_and_the_worlds_last(files):
    models = "b: type: Recorder, name: y | type: Recorder, name: x; a: type: Recorder, name: z"
    world = world_of(files, models, "[{type: WorldRecorder, name: w}]")
    assert calls == [
        ("b/y", "on_initialize"),
        ("b/x", "on_initialize"),
        ("a/z", "on_initialize"),
        ("w", "on_initialize", ["a", "b"]),
    ]
    calls.clear()

    step(world, 2)

    names = ["b/y", "b/x", "a/z", "w"]
    assert calls == [
        *((name, "before", 0) for name in names),
        *((name, "after", 5_000_000) for name in names),
        *((name, "before", 5_000_000) for name in names),
        *((name, "after", 10_000_000) for name in names),
    ]


def test_a_hook_that_is_not_overridden_is_never_called(files, monkeypatch):
    monkeypatch.setattr(Plugin, "before_physics_step", lambda *_: calls.append(("base class",)))
    world = world_of(files, "robot: type: OnlyAfter, name: a")

    step(world)

    assert calls == [("a", "after")]


def test_a_plugin_with_an_update_rate_is_called_when_due(files):
    world = world_of(files, "robot: type: Recorder, name: slow, update_rate: 10")
    calls.clear()

    step(world, 200)

    befores = [time for _, hook, time in calls if hook == "before"]
    afters = [time for _, hook, time in calls if hook == "after"]
    assert befores == [100_000_000 * i for i in range(10)]
    assert afters == [time + 5_000_000 for time in befores]


def test_random_numbers_depend_only_on_seed_model_and_plugin(files):
    two = "type: Dice, name: p | type: Dice, name: q"

    def random_numbers(models: str, seed: int) -> dict:
        calls.clear()
        world_of(files, models, seed=seed)
        return dict(calls)

    numbers = random_numbers(f"a: {two}; b: {two}", 1)
    other_order = random_numbers(f"b: {two}; c: {two}; a: type: Recorder, name: r | {two}", 1)
    other_seed = random_numbers(f"a: {two}; b: {two}", 2)

    assert {name: other_order[name] for name in numbers} == numbers
    assert len({*numbers.values(), *other_seed.values()}) == 8


def test_a_slash_in_a_name_does_not_share_random_numbers():
    names = [("a", "b/c"), ("a/b", "c"), ("", "a/b/c"), ("a", "b"), ("", "b")]

    assert len({_stream(*pair) for pair in names}) == len(names)
