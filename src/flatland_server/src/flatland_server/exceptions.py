"""What can go wrong, as one tree.

    FlatlandError
    ├── YamlError      a file that cannot be read or says something impossible; knows file and line
    ├── ModelError     a model that is not there, or a name that is taken or cannot be used
    └── PluginError    a plugin that is unknown, cannot be imported or does not start

The core adds `GoneError` (a `ReferenceError`): a handle whose body, joint or drive was deleted.
Messages are written for the person who can act on them: where, what was expected, what was found.
"""

import difflib
from pathlib import Path
from typing import Iterable, Optional


class FlatlandError(Exception):
    """Anything that Flatland refuses, with a message for its user."""


class YamlError(FlatlandError):
    """A YAML, image or data file that cannot be read, or a value in it that cannot be.

    Args:
        file: the file at fault.
        message: what was expected and what was found, with the place within the document.
        line: 1-based line of the offending value, if it is known.
        column: 1-based column of it.
    """

    def __init__(
        self, file: Path, message: str, line: Optional[int] = None, column: Optional[int] = None
    ) -> None:
        where = f"{file}:{line}" if line is not None else f"{file}"
        super().__init__(f"{where}: {message}")
        self.file = file
        self.line = line
        self.column = column


class ModelError(FlatlandError):
    """A model that does not exist, or a name that is taken or cannot be used."""


class PluginError(FlatlandError):
    """A plugin that is unknown, cannot be imported, or fails while it starts."""


def suggestion(word: str, known: Iterable[str]) -> str:
    """` (did you mean "range"?)` for a near miss of a known word, or the empty string."""
    near = difflib.get_close_matches(word, list(known), n=1)
    return f' (did you mean "{near[0]}"?)' if near else ""
