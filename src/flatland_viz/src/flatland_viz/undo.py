"""Undo of actions on models."""

from typing import Callable, List, NamedTuple

_LIMIT = 100


class Undoable(NamedTuple):
    """An action and its reversal."""

    text: str
    """The name of the action, such as `Move r2`."""
    undo: Callable[[], None]


class UndoStack:
    """The last actions; the latest is undone first."""

    def __init__(self) -> None:
        self._done: List[Undoable] = []

    def push(self, done: Undoable) -> None:
        """Adds an action."""
        self._done.append(done)
        del self._done[:-_LIMIT]

    def undo(self) -> str:
        """Undoes the latest action; returns its name, or the empty string if there is none."""
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
        """The name of the next action to undo; empty if there is none."""
        return self._done[-1].text if self._done else ""
