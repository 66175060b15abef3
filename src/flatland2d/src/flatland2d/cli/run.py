"""flatland run: simulates a world, as fast as possible or at a rate, and may record it."""

import argparse
import contextlib
import math
import signal
import sys
import time
from types import FrameType
from typing import Callable, Iterator, Optional

from flatland2d.cli.arguments import (
    INTERRUPTED,
    Subparsers,
    add_world,
    handled,
    open_simulation,
    positive,
    signals,
)
from flatland2d.simulation import Simulation
from flatland_server.exceptions import needed_module, suggestion

_CHUNK = 0.05
"""Real time between checks of the clock and of Ctrl-C [s]: the duration of one call of `step`."""


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "run",
        help="simulate a world",
        description="Simulate a world, and say how fast that was. Ctrl-C ends it; what was "
        "recorded until then is complete.",
    )
    add_world(parser)
    parser.add_argument(
        "--seconds", type=positive, metavar="S", help="of simulated time; by default until Ctrl-C"
    )
    parser.add_argument(
        "--rate",
        type=positive,
        default=math.inf,
        metavar="R",
        help="simulated seconds per second of real time; by default as fast as possible",
    )
    parser.add_argument(
        "--record", metavar="FILE", help="record messages: .bag for ROS, .mcap for Foxglove"
    )
    parser.add_argument(
        "--ros2", action="store_true", help="record messages as ROS 2 has them, into an .mcap"
    )
    parser.add_argument(
        "--topics",
        nargs="+",
        metavar="TOPIC",
        help="what is recorded, such as /scan and /tf; by default all topics",
    )
    parser.add_argument(
        "--progress",
        action="store_true",
        default=None,
        help="show a progress bar, even if the output is no terminal",
    )
    parser.add_argument(
        "--no-progress", dest="progress", action="store_false", help="show no progress bar"
    )
    parser.set_defaults(execute=_execute, parser=parser)


def _execute(options: argparse.Namespace) -> int:
    if options.record is None and (options.topics or options.ros2):
        name = "--topics" if options.topics else "--ros2"
        options.parser.error(f"{name} says what to --record")
    with contextlib.ExitStack() as stack:
        simulation = stack.enter_context(open_simulation(options, raise_failures=False))
        if options.record is not None:
            recorder = simulation.record(options.record, options.topics, ros2=options.ros2)
            stack.enter_context(recorder)
            for topic in recorder.unmatched(simulation.topics):
                hint = suggestion(topic, simulation.topics)
                print(f'no plugin has a topic "{topic}" to record{hint}', file=sys.stderr)
        is_interrupted = stack.enter_context(interrupts())
        report = stack.enter_context(_progress_bar(options.progress, options.seconds))
        start = time.monotonic()
        _simulate(simulation, options.seconds, options.rate, is_interrupted, report)
        elapsed = time.monotonic() - start
        failures = simulation.world.plugin_failures
    print(_summary(options, simulation, elapsed))
    for failure in failures:
        print(f'the plugin "{failure.label}" failed in {failure.reason}', file=sys.stderr)
    if options.seconds is not None and is_interrupted():
        return INTERRUPTED
    return 1 if failures else 0


def _simulate(
    simulation: Simulation,
    seconds: Optional[float],
    rate: float,
    is_interrupted: Callable[[], bool],
    report: Callable[[float], None],
) -> None:
    """Makes steps until the time has come, or Ctrl-C.

    Args:
        simulation: the simulation to step.
        seconds: how much simulated time [s]; None is for ever.
        rate: greatest simulated time per real time.
        is_interrupted: true ends the run early.
        report: called now and then, with the simulated time [s].
    """
    step_size = simulation.step_size
    rest = math.inf if seconds is None else max(1, round(seconds / step_size))
    made, chunk = 0, 1
    begin = time.monotonic()
    while rest > made and not is_interrupted():
        if rate < math.inf:
            late = (time.monotonic() - begin) * rate / step_size - made
            if late < 1.0:
                time.sleep(min(_CHUNK, (1.0 - late) * step_size / rate))
                continue
            chunk = min(chunk, int(late))
        count = int(min(chunk, rest - made))
        before = time.monotonic()
        simulation.step(count)
        spent = time.monotonic() - before
        # As many steps as take half to all of the time between two checks.
        chunk = count * 2 if spent < _CHUNK / 2 else max(1, count // 2 if spent > _CHUNK else count)
        made += count
        report(simulation.time)


def _summary(options: argparse.Namespace, simulation: Simulation, elapsed: float) -> str:
    simulated = simulation.time
    steps = round(simulated / simulation.step_size)
    factor = simulated / elapsed if elapsed > 0.0 else 0.0
    line = (
        f"{options.world}: {simulated:.4g} s in {elapsed:.3g} s, {factor:.3g} times real time "
        f"({steps} steps of {simulation.step_size:g} s, seed {simulation.seed})"
    )
    return f"{line}\nrecorded in {options.record}" if options.record else line


@contextlib.contextmanager
def _progress_bar(
    is_wanted: Optional[bool], seconds: Optional[float]
) -> Iterator[Callable[[float], None]]:
    """A bar of tqdm on standard error, if one is wanted.

    Yields:
        A function that shows how much time has been simulated [s].

    Raises:
        MissingPackageError: tqdm is not installed, and a bar was asked for.
    """
    if not (sys.stderr.isatty() if is_wanted is None else is_wanted):
        yield lambda _: None
        return
    tqdm = needed_module("tqdm", "a progress bar needs tqdm", "pip install tqdm")
    form = "{l_bar}{bar}| {n:.1f}/{total:.1f} s [{elapsed}<{remaining}{postfix}]"
    endless = "{n:.1f} s [{elapsed}{postfix}]"
    with tqdm.tqdm(total=seconds, bar_format=form if seconds else endless) as bar:
        start = time.monotonic()

        def report(simulated: float) -> None:
            factor = simulated / max(time.monotonic() - start, 1e-9)
            bar.set_postfix_str(f"{factor:.3g} x real time", refresh=False)
            bar.update(min(simulated, seconds or math.inf) - bar.n)

        yield report


@contextlib.contextmanager
def interrupts() -> Iterator[Callable[[], bool]]:
    """Makes SIGINT (Ctrl-C), SIGTERM and SIGHUP end the run between steps, not within one.

    Yields:
        A function that tells whether a signal has come. A second one ends the process at once.
    """
    received, numbers = [], signals()

    def note(number: int, _: Optional[FrameType]) -> None:
        received.append(number)
        for each in numbers:
            signal.signal(each, signal.SIG_DFL)

    with handled(note):
        yield lambda: bool(received)
