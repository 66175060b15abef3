"""The warnings and errors that a test has logged so far."""

import logging
from typing import List

import pytest


def warnings(caplog: pytest.LogCaptureFixture) -> List[str]:
    """The messages of warnings and errors."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]


def errors(caplog: pytest.LogCaptureFixture) -> List[str]:
    """The messages of errors."""
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.ERROR]
