"""A line for the user when something takes long, and none when it does not."""

import threading

from flatland_server.maps import slow_log as module
from flatland_server.maps.slow_log import log_if_slow


def test_what_takes_long_is_announced_while_it_lasts(monkeypatch):
    said = threading.Event()
    monkeypatch.setattr(module, "PATIENCE", 0.01)
    monkeypatch.setattr(module.logger, "info", lambda message: said.set())

    with log_if_slow("reading walls"):
        assert said.wait(10.0)


def test_what_is_quick_is_not_announced(caplog):
    caplog.set_level("INFO")

    with log_if_slow("reading walls"):
        pass

    assert not caplog.records
