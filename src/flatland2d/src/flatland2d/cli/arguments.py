"""Arguments shared by several subcommands."""

import argparse
import math
import re
import signal
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Tuple

import yaml

from flatland2d.simulation import Simulation
from flatland_server.config import LARGEST
from flatland_server.exceptions import needed_module

INTERRUPTED = 130
"""The exit code of a program ended by Ctrl-C, as in shells."""

_AT_MOST = f"{LARGEST:g} at most"

Subparsers = Any
"""The result of argparse's `add_subparsers`; its class has no public name."""


def add_world(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that name a world and how it is simulated."""
    world: Any = parser.add_argument(
        "world",
        metavar="WORLD",
        help="a world file, or the name of a world that `flatland worlds` lists",
    )
    world.complete = FILES
    parser.add_argument(
        "--seed", type=whole_from(0), default=0, help="of all random numbers (default: %(default)s)"
    )
    parser.add_argument(
        "--step-size",
        type=positive,
        default=0.005,
        metavar="S",
        help="simulated seconds per step (default: %(default)s)",
    )
    add_sources(parser)


def add_sources(parser: argparse.ArgumentParser) -> None:
    """Adds `--models FOLDER` and `--param NAME=VALUE`, which may be repeated.

    `params` is a list of pairs.
    """
    parser.add_argument(
        "--models",
        type=Path,
        action="append",
        default=[],
        metavar="FOLDER",
        help="where models are looked up that are not beside the world file",
    )
    parser.add_argument(
        "--param",
        dest="params",
        type=pair,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter for expressions and plugins, with a value in YAML: --param robots=3",
    )


def add_rate(parser: argparse.ArgumentParser) -> None:
    """Adds `--rate R` of a server, which is real time by default."""
    parser.add_argument(
        "--rate",
        type=lambda text: math.inf if text == "inf" else positive(text),
        default=1.0,
        metavar="R",
        help='simulated seconds per second of real time; "inf" is as fast as possible (default: 1)',
    )


def pair(text: str) -> Tuple[str, Any]:
    """A name and its value, written as NAME=VALUE in YAML."""
    name, separator, value = text.partition("=")
    try:
        if name and separator:
            return name.rstrip(":"), yaml.safe_load(value)  # `:=` as for a node
    except yaml.YAMLError:
        pass
    raise argparse.ArgumentTypeError(f'expected NAME=VALUE with a value in YAML, found "{text}"')


def world_options(options: argparse.Namespace) -> Dict[str, Any]:
    """The arguments of `add_world` for a simulation or a server, but for the world."""
    return {
        "seed": options.seed,
        "step_size": options.step_size,
        "model_folders": options.models,
        "params": dict(options.params),
    }


def open_simulation(options: argparse.Namespace, **more: Any) -> Simulation:
    """The simulation of the world that `add_world`'s arguments name.

    Raises:
        FlatlandError: there is no such world, or something in it is wrong.
    """
    return Simulation(options.world, **world_options(options), **more)


def signals() -> List[signal.Signals]:
    """SIGINT (Ctrl-C), SIGTERM, and SIGHUP of a closed terminal, unless nohup ignores that."""
    is_ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    return [signal.SIGINT, signal.SIGTERM, *([] if is_ignored else [signal.SIGHUP])]


@contextmanager
def handled(handler: Callable[[int, Any], Any]) -> Iterator[None]:
    """Lets a function handle `signals`.

    SIGINT also in a background process, for which the shell has switched it off.
    """
    former = {number: signal.signal(number, handler) for number in signals()}
    try:
        yield
    finally:
        for number, each in former.items():
            signal.signal(number, each)


def positive(text: str) -> float:
    """A number above zero, up to 1e9."""
    return _number(text, lambda value: 0.0 < value <= LARGEST, f"a number above 0, {_AT_MOST}")


def not_negative(text: str) -> float:
    """A number of zero or more, up to 1e9."""
    return _number(
        text, lambda value: 0.0 <= value <= LARGEST, f"a number of 0 or more, {_AT_MOST}"
    )


def whole_from(minimum: int) -> Callable[[str], int]:
    """A whole number of at least `minimum`."""

    def whole(text: str) -> int:
        if text.isdecimal() and int(text) >= minimum:
            return int(text)  # exact, where a float would be rounded
        expected = f"a whole number of {minimum} or more"
        return int(_number(text, lambda value: value >= minimum and value == int(value), expected))

    return whole


def size(text: str) -> Tuple[int, int]:
    """A size such as 640x480 [px]."""
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if not found:
        raise argparse.ArgumentTypeError(f'expected a size such as 640x480, found "{text}"')
    return int(found[1]), int(found[2])


def _number(text: str, holds: Callable[[float], bool], expected: str) -> float:
    try:
        value = float(text)
        if holds(value):
            return value
    except (OverflowError, ValueError):
        pass
    raise argparse.ArgumentTypeError(f'expected {expected}, found "{text}"')


SHELLS = ("bash", "zsh")

FILES = {"bash": "_shtab_compgen_files", "zsh": "_files"}
"""As the attribute `complete` of an argument: it is completed by names of files."""


class PrintCompletion(argparse.Action):
    """Prints a script for a shell, and ends the process."""

    def __call__(self, parser: argparse.ArgumentParser, *arguments: Any, **_: Any) -> None:
        """Prints the script for the shell that the option names."""
        install = "pip install shtab, or apt install python3-shtab"
        shtab = needed_module("shtab", "completion needs shtab", install)
        print(shtab.complete(parser, shell=arguments[1]))
        parser.exit()
