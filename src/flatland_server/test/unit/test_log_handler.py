"""Logs that cannot be written."""

import logging
import sys

import pytest
from rosgraph.roslogging import RosStreamHandler

from flatland_server.ros.log_handler import tolerate_write_errors
from flatland_server.ros.node import open_closed_streams

FULL = "/dev/full"


class ClosedPipe:
    """A terminal that is gone."""

    def isatty(self):
        return False

    def write(self, text):
        raise BrokenPipeError(32, "Broken pipe")


@pytest.fixture
def logger():
    logger = logging.getLogger("test_log_handler")
    logger.propagate = False
    yield logger
    logger.handlers.clear()


def test_a_full_disk_is_reported_once(logger, capsys):
    handler = logging.FileHandler(FULL)
    logger.addHandler(handler)
    tolerate_write_errors()

    for _ in range(3):
        logger.warning("a message")

    text = capsys.readouterr().err
    assert text.startswith(f"log messages are lost, {FULL} cannot be written: [Errno 28]")
    assert len(text.splitlines()) == 1


def test_a_terminal_that_is_gone_does_not_raise(logger, capsys):
    logger.addHandler(RosStreamHandler(stdout=ClosedPipe(), stderr=ClosedPipe()))
    tolerate_write_errors()

    for _ in range(3):
        logger.warning("a message")

    assert capsys.readouterr().err.count("log messages are lost") == 1


def test_a_closed_terminal_does_not_raise(logger, monkeypatch):
    for name in ("stdout", "stderr"):
        monkeypatch.setattr(sys, name, None)
    open_closed_streams()
    logger.addHandler(RosStreamHandler())

    logger.info("a message")
    logger.warning("a message")


def test_other_errors_are_shown_as_before(logger, capsys):
    logger.addHandler(logging.StreamHandler(sys.stderr))
    tolerate_write_errors()

    logger.warning("%d", "not a number")

    assert "TypeError" in capsys.readouterr().err
