"""The exceptions of Flatland, as one tree.

    FlatlandError
    ├── YamlError           a file is missing, unreadable or wrong; has file, line and column
    ├── ModelError          a model does not exist or cannot be created, or its name is not usable
    ├── LayerError          a layer does not exist
    ├── MessageError        a message type is unknown or wrongly defined, or a value is wrong
    ├── MissingPackageError a Python package is needed that is not installed
    ├── PluginError         a plugin is unknown or cannot be imported, or fails in a `Simulation`
    ├── RecordingError      a recording cannot be written or read
    ├── StateError          a state cannot be saved, or does not fit the world it is loaded into
    ├── TopicError          a name is not allowed for a topic or frame, or a topic has another type
    └── UsageError          a program calls something with a wrong value, or after `close`
        └── UnknownArgumentError  an argument has an unknown name: a TypeError, too

The core adds `GoneError`, a `ReferenceError`: a handle to a deleted body, joint or drive is used.
Messages tell the user where the problem is, what was expected and what was found.
"""

import importlib
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Callable, Collection, Iterable, List, Optional, Tuple

MAX_SHOWN = 50
"""The number of problems of a `YamlError` that are shown."""

_MAX_LISTED = 30  # names in a message
_MAX_COMPARED = 200  # words that a misspelt one is compared with
_LONGEST_WORD = 100  # letters of a misspelt word


class FlatlandError(Exception):
    """The base of all errors that Flatland raises on purpose, with a message for the user."""


PLUGIN_ERRORS = (Exception, SystemExit)
"""Exceptions that switch off the plugin: even `sys.exit()` in it does not end the simulation."""


@dataclass(frozen=True)
class Problem:
    """One problem in a file.

    Attributes:
        file: the file that has the problem.
        message: the place within the document, what was expected and what was found.
        line: of the wrong value, from 1; None if it is not known.
        column: of the wrong value, from 1; None if it is not known.
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
        """The problem in the format of compilers: `file:line:column: message`."""
        where = [str(self.file), *(str(n) for n in (self.line, self.column) if n is not None)]
        return f"{':'.join(where)}: {self.message}"


class YamlError(FlatlandError):
    """One or more problems in YAML, image or data files.

    The arguments are the attributes of its only `Problem`; `YamlError.of` makes an error of several
    problems. Its text has a line for each of the first 50 problems, and one with the number of the
    others.

    Args:
        file: path of the file with the problem.
        message: the place within the document, what was expected and what was found.
        line: of the wrong value, from 1; None if it is not known.
        column: of the wrong value, from 1; None if it is not known.

    Attributes:
        problems: all problems, in the order in which they were found; at least one.
    """

    def __init__(
        self, file: Path, message: str, line: Optional[int] = None, column: Optional[int] = None
    ) -> None:
        self.problems: Tuple[Problem, ...] = (Problem(file, message, line, column),)
        super().__init__(file, message, line, column)

    @classmethod
    def of(cls, problems: Iterable[Problem]) -> "YamlError":
        """An error of several problems.

        Args:
            problems: one at least; duplicates are left out.
        """
        unique = tuple(dict.fromkeys(problems))
        error = cls(unique[0].file, unique[0].message, unique[0].line, unique[0].column)
        error.problems = unique
        return error

    def __str__(self) -> str:
        return "\n".join(self.lines(str))

    def lines(self, line_of: Callable[[Problem], str]) -> List[str]:
        """A line for each of the first 50 problems, and one with the number of the others.

        Args:
            line_of: returns the line for a problem.
        """
        lines = [line_of(problem) for problem in self.problems[:MAX_SHOWN]]
        rest = len(self.problems) - len(lines)
        if rest:
            lines.append(f"and {rest} more {'problem' if rest == 1 else 'problems'}")
        return lines

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


class MissingPackageError(FlatlandError, ImportError):
    """A Python package that is needed is not installed; the message says how to install it."""


def needed_module(name: str, need: str, install: str) -> Any:
    """A module of a package that not all users have.

    Args:
        name: of the module, which is imported.
        need: what needs the package, and its name, such as "a plot needs Matplotlib".
        install: how to install it.

    Raises:
        MissingPackageError: it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        reason = str(error).splitlines()[0]
        raise MissingPackageError(f"{need}: {install} ({reason})") from None


def pip_install(extra: str) -> str:
    """The command that installs an extra. flatland2d is on no registry yet, so it names a clone."""
    return f"pip install '.[{extra}]' in Flatland's clone"


class ModelError(FlatlandError):
    """A model or a part of it does not exist or cannot be created, or its name cannot be used."""


class LayerError(FlatlandError):
    """A layer does not exist."""


class MessageError(FlatlandError):
    """A message type is unknown or wrongly defined, or a message has wrong or too little data."""


class PluginError(FlatlandError):
    """A plugin is unknown or cannot be imported, or, in a `Simulation`, has raised an exception."""


class RecordingError(FlatlandError):
    """A recording cannot be written or read."""


class StateError(FlatlandError):
    """The state of a world cannot be saved, or is damaged, or does not fit the world."""


class TopicError(FlatlandError):
    """A name is not allowed for a topic or frame, or the topic already has another type.

    Args:
        message: the text of the error.
        name: of the topic or frame, as the plugin has given it.

    Attributes:
        name: of the topic or frame.
    """

    def __init__(self, message: str, name: str) -> None:
        super().__init__(message)
        self.name = name


class UsageError(FlatlandError, ValueError):
    """A program calls something with a wrong value, or after `close`."""


class UnknownArgumentError(UsageError, TypeError):
    """An argument has an unknown name."""


def shortened(found: object, longest: int = 80) -> str:
    """A found value, mostly text, as one line of at most `longest` characters, for messages."""
    line = " ".join(str(found).split())
    return line if len(line) <= longest else f"{line[: longest - 3]}..."


def listed(names: Collection[str]) -> str:
    """Names for a message, separated by commas: the first 30, and the number of the others."""
    shown = ", ".join(islice(names, _MAX_LISTED))
    rest = len(names) - _MAX_LISTED
    return f"{shown} and {rest} more" if rest > 0 else shown or "none"


def counted(count: int, noun: str) -> str:
    """A number of things, such as "1 layer" and "7 models"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def suggestion(word: object, known: Iterable[str]) -> str:
    """A hint for a misspelt word, such as ` (did you mean "range"?)`; else the empty string.

    Args:
        word: the word that is not known.
        known: the words that it may stand for; the first 200 are compared.
    """
    near = nearest(word, known)
    return "" if near is None else f' (did you mean "{near}"?)'


def unknown(problem: str, word: str, known: Collection[str], there: str = "there are") -> str:
    """The message for a word that is not known, with a hint and the words that are.

    Args:
        problem: what comes before the word, such as "there is no model".
        word: the word that was found.
        known: the words that are valid.
        there: what comes before these.
    """
    return f'{problem} "{shortened(word)}"{suggestion(word, known)}; {there}: {listed(known)}'


def nearest(word: object, known: Iterable[str]) -> Optional[str]:
    """The word that a misspelt one may stand for, whatever its case; None without one.

    Args:
        word: as for `suggestion`.
        known: as for `suggestion`.
    """
    if not isinstance(word, str) or len(word) > _LONGEST_WORD:  # a program may pass anything
        return None
    import difflib  # takes a millisecond

    words = {each.lower(): each for each in islice(known, _MAX_COMPARED)}
    near = difflib.get_close_matches(word.lower(), words, n=1)
    return words[near[0]] if near else None
