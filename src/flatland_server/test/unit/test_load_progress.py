"""Log messages about what takes long: loading a large world, and other blocks."""

import logging
import threading

import numpy as np
import pytest

from flatland_server import _core
from flatland_server.maps import map_reader
from flatland_server.maps.map_reader import log_if_slow
from flatland_server.simulation.load_progress import LoadProgress


def percents(caplog):
    """The percents that were logged."""
    return [record.percent for record in caplog.records]


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


def test_the_core_tells_how_many_walls_it_has_added():
    walls = np.random.default_rng(1).uniform(-50.0, 50.0, (120_000, 4))
    added = []

    _core.World().add_layer(walls, 1, added.append)

    assert added == [50_000, 100_000, 120_000]


def test_a_slow_world_logs_each_ten_percent_and_the_end(caplog):
    caplog.set_level(logging.INFO)
    progress = LoadProgress(1000, delay=0.0)

    for added in range(0, 601, 40):
        progress.update(added)
    progress.layer_is_complete(600)
    progress.update(400)

    assert percents(caplog) == [12, 20, 32, 40, 52, 60, 100]
    assert caplog.records[-1].getMessage() == "walls: 100 %"


@pytest.mark.parametrize("walls", [1, 1000])
def test_a_world_that_is_loaded_at_once_logs_nothing(caplog, walls):
    caplog.set_level(logging.INFO)

    LoadProgress(walls).update(walls)

    assert percents(caplog) == []
