"""Checks of a plugin's behaviour while time passes. Each yields the problems that it finds."""

import inspect
import logging
import math
from contextlib import contextmanager
from typing import Any, Callable, Dict, Iterator, List, Tuple

import numpy as np

from flatland_server.canvas import Canvas
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.testing.checked_plugin import (
    ROBOT,
    CheckedPlugin,
    Names,
    ObservedRun,
    filled,
    with_value,
)

Problems = Iterator[str]

SECONDS = 0.5
"""The duration of simulations [s]."""


def check_messages(case: CheckedPlugin) -> Problems:
    """Equal seeds give equal messages, transforms and worlds; a writer's bytes are its message."""
    runs = [case.load(seed=7).go(SECONDS) for _ in range(2)]
    first, second = ((content_of(run), state_of(run)) for run in runs)
    yield from _check_same(first, second, "from equal seeds")
    for topic in sorted(set(runs[0].transport.wrong_data)):
        yield f"expected the MessageWriter of {topic} to make bytes that equal its message"


def check_rates(case: CheckedPlugin) -> Problems:
    """With `update_rate` or `pub_rate`, messages come at that rate, stamped with their step."""
    for key in ("update_rate", "pub_rate"):
        if key not in case.entry:
            continue
        for rate, period in (("inf", 1), (40, 5)):
            run = case.load(with_value(case.entry, (key,), rate)).go(SECONDS)
            yield from _check_period(run, period, f"{key}: {rate}")


def _check_period(run: ObservedRun, period: int, label: str) -> Problems:
    steps: Dict[Any, List[int]] = {}
    stamps: List[Tuple[str, int, int]] = []  # topic or frame, stamp, time of sending
    for event in run.transport.events:
        steps.setdefault(event.topic, []).append(event.step)
        header = getattr(event.message, "header", None)
        if header is not None:
            stamps.append((event.topic, header.stamp.to_nsec(), event.nanoseconds))
    for step, now, transform in run.transport.sent_transforms:
        steps.setdefault((transform.parent, transform.child), []).append(step)
        stamps.append((transform.child, transform.nanoseconds, now))
    expected = list(range(1, run.transport.step, period))
    for what, found in steps.items():
        gaps = {later - earlier for earlier, later in zip(found, found[1:])}
        is_steady = len(gaps) == 1 and len(found) > 2  # rather than published on events
        is_wrong = found != expected if is_steady else not set(found) <= set(expected)
        if is_wrong and what not in run.transport.latched:
            yield f"{label}: expected {what} in steps 1, {1 + period} ..., found {found[:9]} ..."
    wrong = [each for each in stamps if each[1] != each[2]]
    for what, stamp, now in wrong[:1]:
        yield f"{label}: expected {what} to be stamped with the time, {now} ns, found {stamp} ns"


def check_without_subscribers(case: CheckedPlugin) -> Problems:
    """Without subscribers, no message is made or published; later ones do not depend on that."""
    run = case.load(has_subscribers=False)
    transport = run.transport
    with transport.counting_messages() as made:
        run.go(SECONDS)
    early = {event.topic for event in transport.events} - transport.latched
    for topic in sorted(early):
        yield f"without subscribers: expected no message, found one published to {topic}"
    for topic in sorted(set(made) - early):
        yield f"without subscribers: expected no message made for {topic}, found {made[topic]}"
    for child in sorted({transform.child for _, _, transform in transport.sent_transforms}):
        yield f'without subscribers: expected no transform, found one of the frame "{child}"'
    yield from _check_late_subscriber(case, run)


def _check_late_subscriber(case: CheckedPlugin, run: ObservedRun) -> Problems:
    """The messages to a late subscriber are those of a run with subscribers from the start."""
    transport = run.transport
    subscribed = case.load().go(SECONDS)
    subscribed.simulation.run(SECONDS)
    seen = len(transport.events), len(transport.sent_transforms)
    transport.set_subscribed_topics(None)
    run.simulation.run(SECONDS)
    late = content_of(run, *seen)
    expected = [each for each in content_of(subscribed) if each[0] > late[0][0]] if late else []
    if [each for each in late if each[0] > late[0][0]] != expected:
        yield "expected the same messages, however late a topic gets its subscriber"
    topics = {event.topic for event in transport.events}
    for topic in sorted({event.topic for event in subscribed.transport.events} - topics):
        yield f"expected a message on {topic} after it has got a subscriber, found none"


def content_of(
    run: ObservedRun, events: int = 0, transforms: int = 0
) -> List[Tuple[int, str, bytes]]:
    """Everything that was sent, in order: the step, the topic or frame, and the content."""
    sent = [(e.step, e.topic, e.data) for e in run.transport.events[events:]]
    for step, _, transform in run.transport.sent_transforms[transforms:]:
        sent.append((step, transform.child, repr(transform).encode()))
    return sorted(sent, key=lambda each: each[:2])


def state_of(run: ObservedRun) -> Tuple[Any, ...]:
    """The poses of all models, and the walls of all layers."""
    world = run.simulation.world
    poses = {name: model.pose for name, model in world.models.items()}
    return poses, [layer.segments.tolist() for layer in world.layers]


def check_states(case: CheckedPlugin) -> Problems:
    """A run goes on in another world from a saved state; after a reset, it begins again."""
    run = case.load(seed=7).go(SECONDS)
    first, began_with = content_of(run), state_of(run)
    state = run.simulation.save_state()
    other = case.load(seed=8)
    other.simulation.load_state(state)
    other.transport.step = run.transport.step
    ends = []
    for each in (run, other):
        each.simulation.allow_failures = True
        sent = len(each.transport.events), len(each.transport.sent_transforms)
        ends.append((content_of(each.go(SECONDS), *sent), state_of(each)))
    for failure in other.simulation.world.plugin_failures:
        yield f"expected no failure after its state was loaded, found {failure.reason}"
    hint = "; get_state returns what a plugin keeps in attributes, and set_state sets it"
    loaded = "after its state was saved and loaded in a new world"
    yield from _check_same(ends[0], ends[1], loaded, hint)
    run.simulation.reset()
    run.transport.step = 1
    sent = len(run.transport.events), len(run.transport.sent_transforms)
    again = content_of(run.go(SECONDS), *sent), state_of(run)
    yield from _check_same((first, began_with), again, "after a reset", hint)


def _check_same(
    expected: Tuple[Any, Any], found: Tuple[Any, Any], when: str, hint: str = ""
) -> Problems:
    """Compares contents and states of runs."""
    if expected[0] != found[0]:
        different = [f"{a[1]} in step {a[0]}" for a, b in zip(expected[0], found[0]) if a != b]
        where = (different or ["their number"])[0]
        yield f"expected the same messages {when}, found a difference in {where}{hint}"
    if expected[1] != found[1]:
        yield f"expected the same poses and walls {when}, found a difference"


def check_bad_messages(case: CheckedPlugin) -> Problems:
    """Messages that are empty, NaN or infinite do not make the plugin fail."""
    for value in (0.0, math.nan, -math.inf):
        run = case.load()
        run.simulation.allow_failures = True
        for topic in run.names.subscribed:
            run.simulation.send(topic, filled(run.transport.types[topic](), value))
            run.simulation.run(0.1)
        for failure in run.simulation.world.plugin_failures:
            yield f"expected a message full of {value} to be ignored, found {failure.reason}"


def check_end(case: CheckedPlugin) -> Problems:
    """Its end leaves nothing behind, and the robot can be spawned again."""
    with _warnings() as warnings:
        run = case.load()
        world, transport = run.simulation.world, run.transport
        before = run.go(SECONDS).names
        world.close() if case.is_of_world else world.delete_model(ROBOT)
        yield from _check_nothing_left(run, before)
        if case.is_of_world:
            return
        counts = world.physics.body_count, world.physics.joint_count
        case.spawn(run.simulation)
        of_place = world.overlap_warning(run.simulation.model(ROBOT))  # not the plugin's fault
        after = run.go(SECONDS).names
        if (after.published, after.subscribed) != (before.published, before.subscribed):
            yield "expected the topics of the first robot after it was spawned again"
        world.delete_model(ROBOT)
        if (world.physics.body_count, world.physics.joint_count) != counts:
            yield "expected no body or joint of a deleted robot, found one that is left"
        transport.process()
    for warning in filter(lambda each: each != of_place, warnings):
        yield f"expected no warning while the robot is deleted and spawned, found: {warning}"


def _check_nothing_left(run: ObservedRun, before: Names) -> Problems:
    transport = run.transport
    for topic in sorted(transport.topics):
        yield f"after its end: expected no publisher, found one of {topic}"
    for topic in sorted(transport.subscribed):
        yield f"after its end: expected no subscription, found one of {topic}"
    sent = len(transport.events), len(transport.sent_transforms)
    for topic in before.subscribed:
        run.simulation.send(topic, transport.types[topic]())
    run.simulation.run(0.1)
    for topic in sorted({event.topic for event in transport.events[sent[0] :]}):
        yield f"after its end: expected no message, found one on {topic}"
    for child in sorted({each.child for _, _, each in transport.sent_transforms[sent[1] :]}):
        yield f'after its end: expected no transform, found one of "{child}"'
    if run.loader.living_plugins():
        yield "after its end: expected no reference to the plugin, found one"


@contextmanager
def _warnings() -> Iterator[List[str]]:
    """The warnings and errors that are logged meanwhile."""
    messages: List[str] = []
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: messages.append(record.getMessage())  # type: ignore[method-assign]
    root = logging.getLogger()
    root.addHandler(handler)
    try:
        yield messages
    finally:
        root.removeHandler(handler)


_COLUMNS = {"corners": 2, "points": 2, "center": 2, "point": 2, "segments": 4}
"""The numbers of a row, by the names of a canvas's parameters."""

_COLORS = ("fill", "outline", "color")


class CheckingCanvas:
    """A `Canvas` that draws nothing, and raises the errors of wrong shapes and colours."""

    def __getattr__(self, name: str) -> Callable[..., None]:
        signature = inspect.signature(getattr(Canvas, name))

        def draw(*arguments: Any, **named: Any) -> None:
            _, *given = signature.bind(self, *arguments, **named).arguments.items()
            for parameter, value in given:
                if parameter in _COLORS:
                    np.asarray((0.0,) * 4 if value is None else value, dtype=float).reshape(4)
                elif parameter != "text":
                    np.asarray(value, dtype=float).reshape(-1, _COLUMNS.get(parameter, 1))

        return draw


def check_drawing(case: CheckedPlugin) -> Problems:
    """A plugin that draws itself does so without an error, and pictures change nothing."""
    runs = [case.load(seed=7) for _ in range(2)]
    world = runs[1].simulation.world
    plugins = [each for owner in ["", *world.models] for each in world.plugins_of(owner).values()]
    if all(type(plugin).draw is Plugin.draw for plugin in plugins):
        return
    runs[1].simulation.allow_failures = True
    canvas: Any = CheckingCanvas()
    for _ in range(3):
        world.contents.plugins.draw(canvas, runs[1].simulation.timekeeper)
        for run in runs:
            run.go(SECONDS / 5)
    for failure in world.plugin_failures:
        yield f"expected to draw itself, found {failure.reason}"
    if [content_of(runs[0]), state_of(runs[0])] != [content_of(runs[1]), state_of(runs[1])]:
        yield "expected the same run with pictures as without, found a difference"


def check_readings(case: CheckedPlugin) -> Problems:
    """Readings change nothing in the run, are equal at one time, and need no subscribers."""
    run = case.load(seed=7)
    if not _readings(run):
        return
    silent = case.load(seed=7).go(SECONDS)
    alone = case.load(seed=7, has_subscribers=False)
    for each in (run, alone):
        each.go(0.0)
    step = run.simulation.timekeeper.step_size
    for _ in range(round(SECONDS / step)):
        first, second = _readings(run), _readings(run)
        if first != second:
            yield f"expected equal readings at one time, found {first[0]} and {second[0]}"
            return
        if _readings(alone) != first:
            yield f"expected the same reading without subscribers, found {_readings(alone)[0]}"
            return
        run.simulation.run()
        alone.simulation.run()
    if content_of(run) != content_of(silent):
        yield "expected the same messages after readings, found a difference"
    if state_of(run) != state_of(silent):
        yield "expected the same poses and walls after readings, found a difference"


def _readings(run: ObservedRun) -> List["_Reading"]:
    """The present readings of the plugin; none if it is no sensor."""
    plugins: List[Any] = list(run.simulation.world.plugins_of(ROBOT).values())
    return [
        _Reading(read(run.simulation.timekeeper))
        for plugin in plugins
        if type(plugin).read is not ModelPlugin.read
        for read in (plugin.read, *(getattr(plugin, f"read_{each}") for each in plugin.quantities))
    ]


class _Reading:
    """A value that was read; equal to another one of the same bits, NaN included."""

    def __init__(self, value: Any) -> None:
        self._value = value
        # The string of an array takes milliseconds, and leaves out the middle of a long one.
        is_array = isinstance(value, np.ndarray)
        self._bits = (value.dtype, value.shape, value.tobytes()) if is_array else repr(value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Reading) and self._bits == other._bits

    def __str__(self) -> str:
        return repr(self._value)
