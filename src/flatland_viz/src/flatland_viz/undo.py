"""What was done to models and can be undone."""

from typing import Callable, List, NamedTuple

_LIMIT = 100


class Undoable(NamedTuple):
    """Something that was done."""

    text: str
    """Such as `Move r2`."""
    undo: Callable[[], None]


class UndoStack:
    """The last things that were done; the latest is undone first."""

    def __init__(self) -> None:
        self._done: List[Undoable] = []

    def push(self, done: Undoable) -> None:
        """Notes what was done."""
        self._done.append(done)
        del self._done[:-_LIMIT]

    def undo(self) -> str:
        """Undoes the latest; returns its text, or the empty string if there is none."""
        if not self._done:
            return ""
        done = self._done.pop()
        done.undo()
        return done.text

    def clear(self) -> None:
        """Forgets everything: the world is another one."""
        self._done.clear()

    @property
    def text(self) -> str:
        """What would be undone; empty if there is nothing."""
        return self._done[-1].text if self._done else ""
