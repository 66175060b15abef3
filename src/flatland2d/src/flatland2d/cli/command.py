"""The command line: runs a subcommand, and reports its errors."""

import argparse
import atexit
import gc
import io
import logging
import os
import sys
from typing import List, Optional

from flatland2d.cli import check, map_to_lines, recover, render, run, serve, sweep, view, worlds
from flatland2d.cli.arguments import INTERRUPTED, SHELLS, PrintCompletion
from flatland_server._core import __version__
from flatland_server.exceptions import FlatlandError, YamlError

SUBCOMMANDS = (check, map_to_lines, recover, render, run, serve, sweep, view, worlds)


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the command.

    Args:
        arguments: of the command line; by default those of the process.

    Returns:
        The exit code: 0, or 1 if something is wrong with files, models or the machine. Arguments
        that the command does not know end the process with 2.
    """
    if sys.stderr is None:  # closed; no file that is opened later may get its number
        sys.stderr = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")
    atexit.register(gc.freeze)  # no garbage collection at exit, to save time
    parser = argparse.ArgumentParser(
        prog="flatland", description="A 2D robot simulator: worlds in YAML, robots of plugins."
    )
    parser.add_argument("--version", action="version", version=f"flatland {__version__}")
    parser.add_argument(
        "--print-completion",
        action=PrintCompletion,
        choices=SHELLS,
        metavar="SHELL",
        help=f"print completion for a shell: {' or '.join(SHELLS)}",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for subcommand in SUBCOMMANDS:
        subcommand.add_parser(commands)
    logging.basicConfig(format="%(message)s", level=logging.WARNING)
    for stream in (sys.stdout, sys.stderr):  # names of files and errors may have no UTF-8
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        try:
            options, unknown = parser.parse_known_args(arguments)
            if unknown:  # argparse's own error has the usage of `flatland`, without the options
                command = commands.choices[options.command]
                command.error(f"unrecognized arguments: {' '.join(unknown)}")
            code: int = options.execute(options)
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
        if sys.stdout is None:
            code = _fail("flatland: the output cannot be written: it is closed")
    except YamlError as error:
        code = _fail("\n".join(error.lines(lambda problem: problem.with_column)))
    except FlatlandError as error:
        code = _fail(f"flatland: {error}")
    except FileNotFoundError as error:
        if error.filename is not None:
            raise
        code = _fail("flatland: the working directory is not there")
    except OSError as error:
        if error.filename is not None:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
        if not isinstance(error, BrokenPipeError):  # such as `flatland worlds | head -1`
            _fail(f"flatland: the output cannot be written: {error.strerror}")
    except KeyboardInterrupt:
        code = INTERRUPTED
    return code


def _fail(message: str) -> int:
    print(message, file=sys.stderr)
    return 1
