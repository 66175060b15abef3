"""The journal of a sweep: a line for each scenario that is done; the rest can be done later.

A line is written at once and in one piece. The last one may be incomplete after a crash; it is then
cut off, and its scenario is run again.
"""

import fcntl
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Tuple

from flatland_server.exceptions import FlatlandError
from flatland_server.sweep.runner import Result

_FORMAT = "flatland sweep 1"


@dataclass(frozen=True)
class Entry:
    """A scenario that is done.

    Attributes:
        result: of the scenario.
        seconds: of real time.
        attempts: how often it was begun.
    """

    result: Result
    seconds: float
    attempts: int


class Journal:
    """The results so far, by the fingerprints of their scenarios, and the file that they are in.

    Args:
        path: of the file; created if it does not exist.

    Attributes:
        entries: by fingerprint.

    Raises:
        FlatlandError: the file cannot be written, is something else, or another sweep writes it.
    """

    def __init__(self, path: Path) -> None:
        self.entries: Dict[str, Entry] = {}
        self._path = path
        try:
            self._file = open(path, "a+b", buffering=0)  # noqa: SIM115
        except OSError as error:
            raise FlatlandError(f"{path}: cannot be written: {error.strerror}") from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._read()
        except BlockingIOError:
            self.close()
            raise FlatlandError(f"{path.parent}: another sweep writes its results there") from None
        except BaseException:
            self.close()
            raise

    def add(self, fingerprint: str, entry: Entry) -> None:
        """Writes the result of a scenario."""
        self.entries[fingerprint] = entry
        result = entry.result
        self._write(
            {
                "scenario": fingerprint,
                "row": result.row,
                "returned": result.returned,
                "error": result.error,
                "traceback": result.traceback,
                "seconds": entry.seconds,
                "attempts": entry.attempts,
            }
        )

    def close(self) -> None:
        """Closes the file."""
        self._file.close()

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write(self, content: Dict[str, Any]) -> None:
        line = json.dumps(content).encode() + b"\n"
        try:
            if self._file.write(line) != len(line):
                raise OSError(0, "the disk is full")
        except OSError as error:
            raise FlatlandError(f"{self._path}: cannot be written: {error.strerror}") from None

    def _read(self) -> None:
        """Reads the file, and cuts off an incomplete line at its end."""
        self.entries, end = _read(self._path)
        os.ftruncate(self._file.fileno(), end)
        if end == 0:
            self._write({"format": _FORMAT})


def read_entries(path: Path) -> Dict[str, Entry]:
    """The results of a journal, by fingerprint; none if there is no such file.

    Raises:
        FlatlandError: it is no journal, or is damaged.
    """
    return _read(path)[0] if path.exists() else {}


def _read(path: Path) -> Tuple[Dict[str, Entry], int]:
    """The entries of a journal, and the size of its complete lines [bytes]."""
    content = path.read_bytes()
    end = content.rfind(b"\n") + 1
    entries: Dict[str, Entry] = {}
    try:
        for number, line in enumerate(map(json.loads, content[:end].splitlines())):
            if number == 0:
                if line["format"] != _FORMAT:
                    raise ValueError
                continue
            result = Result(line["row"], line["returned"], line["error"], line["traceback"])
            entries[line["scenario"]] = Entry(result, line["seconds"], line["attempts"])
    except (ValueError, KeyError, TypeError):
        raise FlatlandError(f"{path}: is no journal of a sweep, or is damaged") from None
    return entries, end
