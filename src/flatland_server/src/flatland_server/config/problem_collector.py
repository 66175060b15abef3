"""Collecting the problems of a document, so that they are reported together."""

from contextlib import contextmanager
from typing import Dict, Iterator

from flatland_server.exceptions import MAX_SHOWN, Problem, YamlError


class ProblemCollector:
    """The problems found in a document so far, each once, in the order in which they were found.

    The readers of a document and of the sections in it share one collector. An entry of a list has
    a collector of its own, because it is read or left out as a whole; the document takes over its
    problems when it has been read (see `part`).

    Args:
        before: how many problems were found in the document before.
    """

    def __init__(self, before: int = 0) -> None:
        self._problems: Dict[Problem, None] = {}  # a set that keeps its order
        self._before = before

    @property
    def is_full(self) -> bool:
        """True if a further problem would only be counted, so that its text does not matter."""
        return self._before + len(self._problems) >= MAX_SHOWN

    @property
    def is_empty(self) -> bool:
        """True if no problem was found so far."""
        return not self._problems

    def note(self, error: YamlError) -> None:
        """Adds the problems of an error."""
        self._problems.update(dict.fromkeys(error.problems))

    def drop(self, error: YamlError) -> None:
        """Removes the problems of an error."""
        for problem in error.problems:
            self._problems.pop(problem, None)

    def clear(self) -> None:
        """Drops all problems."""
        self._problems.clear()

    def take(self) -> YamlError:
        """All problems as one error, to be raised; none are left. There must be one at least."""
        error = YamlError.of(self._problems)
        self.clear()
        return error

    @contextmanager
    def part(self) -> Iterator["ProblemCollector"]:
        """A collector for an entry of a list, while that is read.

        A YamlError ends the block and is noted. At the end of the block, the problems of the entry
        are added to those of the document.
        """
        part = ProblemCollector(self._before + len(self._problems))
        try:
            yield part
        except YamlError as error:
            part.note(error)
        self._problems.update(part._problems)


class MutedCollector(ProblemCollector):
    """Drops problems in a section that is missing or not a map, which is noted already.

    Args:
        document: collector of the document, which has the problem.
    """

    def __init__(self, document: ProblemCollector) -> None:
        super().__init__()
        self._document = document

    @property
    def is_empty(self) -> bool:
        return self._document.is_empty

    def note(self, error: YamlError) -> None:
        pass

    def take(self) -> YamlError:
        return self._document.take()
