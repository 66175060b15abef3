"""What can go wrong, as one tree.

    FlatlandError
    ├── YamlError      files that cannot be read or say something impossible; knows file and line
    ├── ModelError     a model that is not there, or a name that is taken or cannot be used
    ├── LayerError     a layer that is not there
    └── PluginError    a plugin that is unknown or cannot be imported

The core adds `GoneError` (a `ReferenceError`): a handle whose body, joint or drive was deleted.
Messages are written for the person who can act on them: where, what was expected, what was found.
"""

import difflib
from dataclasses import dataclass
from pathlib import Path
from typing import Iterable, Optional, Tuple


class FlatlandError(Exception):
    """Anything that Flatland refuses, with a message for its user."""


@dataclass(frozen=True)
class Problem:
    """Something wrong in a file: where, and what was expected and found.

    Attributes:
        file: the file at fault.
        message: with the place within the document.
        line: 1-based line of the offending value, if it is known.
        column: 1-based column of it.
    """

    file: Path
    message: str
    line: Optional[int] = None
    column: Optional[int] = None

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}" if self.line is not None else f"{self.file}"
        return f"{where}: {self.message}"

    @property
    def with_column(self) -> str:
        """The same as editors and compilers write it, `file:line:column: message`."""
        where = [str(self.file), *(str(n) for n in (self.line, self.column) if n is not None)]
        return f"{':'.join(where)}: {self.message}"


class YamlError(FlatlandError):
    """One or more things wrong in YAML, image or data files; a line for each.

    Args: those of the first `Problem`; `YamlError.of` makes one of several.
    """

    def __init__(
        self, file: Path, message: str, line: Optional[int] = None, column: Optional[int] = None
    ) -> None:
        self.problems: Tuple[Problem, ...] = (Problem(file, message, line, column),)
        super().__init__(file, message, line, column)

    @classmethod
    def of(cls, problems: Iterable[Problem]) -> "YamlError":
        """An error of all these problems, each named once; there must be one at least."""
        unique = tuple(dict.fromkeys(problems))
        error = cls(unique[0].file, unique[0].message, unique[0].line, unique[0].column)
        error.problems = unique
        return error

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)

    @property
    def file(self) -> Path:
        """The file of the first problem."""
        return self.problems[0].file

    @property
    def line(self) -> Optional[int]:
        """The line of the first problem."""
        return self.problems[0].line

    @property
    def column(self) -> Optional[int]:
        """The column of the first problem."""
        return self.problems[0].column


class ModelError(FlatlandError):
    """A model that does not exist, or a name that is taken or cannot be used."""


class LayerError(FlatlandError):
    """A layer that does not exist."""


class PluginError(FlatlandError):
    """A plugin that is unknown or cannot be imported."""


def suggestion(word: str, known: Iterable[str]) -> str:
    """` (did you mean "range"?)` for a near miss of a known word, or the empty string."""
    near = difflib.get_close_matches(word, list(known), n=1)
    return f' (did you mean "{near[0]}"?)' if near else ""
