"""A message is logged for a slow operation, and none for a quick one."""

import threading

from flatland_server.maps import map_reader
from flatland_server.maps.map_reader import log_if_slow


def test_a_slow_block_is_logged_while_it_runs(monkeypatch):
    logged = threading.Event()
    monkeypatch.setattr(map_reader, "DELAY", 0.01)
    monkeypatch.setattr(map_reader.logger, "info", lambda message: logged.set())

    with log_if_slow("reading walls"):
        assert logged.wait(10.0)


def test_a_quick_block_is_not_logged(caplog):
    caplog.set_level("INFO")

    with log_if_slow("reading walls"):
        pass

    assert not caplog.records
