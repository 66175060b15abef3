"""The undo stack."""

from functools import partial

from flatland_viz.undo import Undoable, UndoStack


def test_the_latest_is_undone_first():
    undone, stack = [], UndoStack()
    for name in ("Move r2", "Delete r2"):
        redo = partial(undone.append, f"{name} again")
        stack.push(Undoable(name, partial(undone.append, name), redo))

    assert stack.text == "Delete r2"
    assert [stack.undo(), stack.undo(), stack.undo()] == ["Delete r2", "Move r2", ""]
    assert undone == ["Delete r2", "Move r2"]


def test_another_world_has_nothing_to_undo():
    stack = UndoStack()
    stack.push(Undoable("Move r2", _nothing, _nothing))
    stack.push(Undoable("Move r3", _nothing, _nothing))
    stack.undo()
    stack.clear()

    assert (stack.text, stack.undo(), stack.redo_text, stack.redo()) == ("", "", "", "")


def test_what_was_undone_is_done_again_until_something_else_is_done():
    done, stack = [], UndoStack()
    for name in ("Move r2", "Delete r2"):
        stack.push(Undoable(name, _nothing, partial(done.append, name)))
    stack.undo()
    stack.undo()

    assert (stack.redo_text, stack.redo(), stack.redo()) == ("Move r2", "Move r2", "Delete r2")
    assert done == ["Move r2", "Delete r2"]
    assert (stack.text, stack.redo_text, stack.redo()) == ("Delete r2", "", "")
    stack.undo()
    stack.push(Undoable("Spawn r3", _nothing, _nothing))
    assert stack.redo_text == ""


def test_it_is_saved_until_something_is_done_or_undone():
    stack = UndoStack()
    assert stack.is_saved
    stack.push(Undoable("Move r2", _nothing, _nothing))
    assert not stack.is_saved
    stack.note_saved()
    assert stack.is_saved
    stack.undo()
    assert not stack.is_saved
    stack.redo()
    assert stack.is_saved


def _nothing():
    pass
