"""Undo and redo of actions on models."""

from typing import Callable, List, NamedTuple, Optional

_LIMIT = 100


class Undoable(NamedTuple):
    """An action that was done, its reversal, and its repetition."""

    text: str
    """The name of the action, such as `Move r2`."""
    undo: Callable[[], None]
    redo: Callable[[], None]


class UndoStack:
    """The last actions; the latest is undone first, and what was undone last is redone first."""

    def __init__(self) -> None:
        self._done: List[Undoable] = []
        self._undone: List[Undoable] = []
        self._saved: Optional[Undoable] = None

    def push(self, done: Undoable) -> None:
        """Adds an action; what has been undone before cannot be redone any more."""
        self._done.append(done)
        del self._done[:-_LIMIT]
        self._undone.clear()

    def undo(self) -> str:
        """Undoes the latest action; returns its name, or the empty string if there is none."""
        if not self._done:
            return ""
        done = self._done.pop()
        self._undone.append(done)
        done.undo()
        return done.text

    def redo(self) -> str:
        """Does what was undone last again; returns its name, or the empty string."""
        if not self._undone:
            return ""
        undone = self._undone.pop()
        self._done.append(undone)
        undone.redo()
        return undone.text

    def clear(self) -> None:
        """Forgets everything: the world is another one."""
        self._done.clear()
        self._undone.clear()
        self._saved = None

    def note_saved(self) -> None:
        """Notes that all of them are in the world's file."""
        self._saved = self._last

    @property
    def is_saved(self) -> bool:
        """True if nothing was done or undone since all was saved."""
        return self._last is self._saved

    @property
    def _last(self) -> Optional[Undoable]:
        return self._done[-1] if self._done else None

    @property
    def text(self) -> str:
        """The name of the next action to undo; empty if there is none."""
        return self._done[-1].text if self._done else ""

    @property
    def redo_text(self) -> str:
        """The name of the next action to redo; empty if there is none."""
        return self._undone[-1].text if self._undone else ""
