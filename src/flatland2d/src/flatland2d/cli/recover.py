"""flatland recover: makes a recording out of one that was not finished."""

import argparse
from contextlib import closing
from pathlib import Path

from flatland2d.cli.arguments import Subparsers
from flatland2d.recording_file import UNFINISHED, RecordingFile, read_recording
from flatland_server.exceptions import RecordingError, counted


def add_parser(commands: Subparsers) -> None:
    """Adds the subcommand."""
    parser = commands.add_parser(
        "recover",
        help="finish a recording of a process that was killed",
        description="Copy the messages of a recording of Flatland into a new one, up to its last "
        "complete chunk: after its process was killed, or from .bag to .mcap and back.",
    )
    parser.add_argument("recording", type=Path, metavar="FILE", help="such as run.bag.active")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="a new .bag or .mcap (default: the name without .active)",
    )
    parser.set_defaults(execute=_execute, parser=parser)


def _execute(options: argparse.Namespace) -> int:
    source: Path = options.recording
    if options.output is None and source.suffix != UNFINISHED:
        options.parser.error(f"expected a FILE that ends with {UNFINISHED}, or --output")
    output = options.output or source.with_suffix("")
    messages = read_recording(source)
    first = next(messages, None)
    if first is None:
        raise RecordingError(f"{source}: expected a complete chunk, found none")
    count, start, end = 1, first.nanoseconds, first.nanoseconds
    with closing(RecordingFile(output, ".recovered", first.channel.encoding)) as file:
        file.write(*first)
        for message in messages:
            file.write(*message)
            count, end = count + 1, message.nanoseconds
    span = f"{start * 1e-9:.3f} s to {end * 1e-9:.3f} s"
    print(f"{output}: {counted(count, 'message')} of {span}")
    return 0
