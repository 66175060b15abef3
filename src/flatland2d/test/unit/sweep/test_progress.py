"""The progress of a sweep: lines, and a bar on a terminal."""

import sys

import pytest

from flatland2d.cli.sweep import show_progress
from flatland2d.sweep.runner import Result


def show(total, done, *, is_wanted=True):
    """Counts the scenarios that are not done yet; the last one has failed."""
    with show_progress(total, done, is_wanted) as progress:
        progress.say("a worker was killed")
        for _ in range(total - done - 1):
            progress.count(Result({"success": True}, {}))
        progress.count(Result({}, {}, "it crashed"))
        progress.end()


def test_without_a_terminal_there_are_lines(capsys):
    show(5, 2)

    said, first, last = capsys.readouterr().err.splitlines()
    assert said == "a worker was killed"
    assert first.startswith("3 of 5 scenarios, 1 with success, ")
    assert last.startswith("5 of 5 scenarios, 2 with success, 1 failed, ")


def test_on_a_terminal_there_is_a_bar(capsys, monkeypatch):
    pytest.importorskip("tqdm")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)

    show(5, 2)

    error = capsys.readouterr().err
    assert "a worker was killed\n" in error
    assert "5/5" in error
    assert "2 with success, 1 failed" in error


def test_nothing_but_messages_is_shown_if_it_is_not_wanted(capsys):
    show(5, 2, is_wanted=False)

    assert capsys.readouterr().err == "a worker was killed\n"
