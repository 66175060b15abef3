"""The undo stack."""

from functools import partial

from flatland_viz.undo import Undoable, UndoStack


def test_the_latest_is_undone_first():
    undone, stack = [], UndoStack()
    for name in ("Move r2", "Delete r2"):
        stack.push(Undoable(name, partial(undone.append, name)))

    assert stack.text == "Delete r2"
    assert [stack.undo(), stack.undo(), stack.undo()] == ["Delete r2", "Move r2", ""]
    assert undone == ["Delete r2", "Move r2"]


def test_another_world_has_nothing_to_undo():
    stack = UndoStack()
    stack.push(Undoable("Move r2", lambda: None))
    stack.clear()

    assert (stack.text, stack.undo()) == ("", "")
