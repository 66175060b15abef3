"""The server's last warnings and errors, for those that come later."""

import logging

import pytest

from flatland_server.hub.recent_log import RecentLog
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.timekeeper import Timekeeper

DISC = "{bodies: [{name: base, footprints: [{type: circle, radius: 1, density: 1}]}]}"
WORLD = f"""\
properties: {{}}
layers: [{{name: walls}}]
models: [{{name: a, model: {DISC}}}]
"""


class Server:
    """A simulation with a log; `tick` is a pass of its loop."""

    def __init__(self, files, logger):
        self.logger = logger
        log = RecentLog(logger)
        logger.warning("before there was a world")
        self.world = files.load(WORLD)
        self.manager = SimulationManager(self.world, Timekeeper(0.5))
        log.open(self.manager)
        self.manager.on_tick.append(log.update)

    def tick(self):
        for callback in self.manager.on_tick:
            callback()

    def entries(self):
        """The last message's texts, levels, numbers and times."""
        self.tick()
        transport = self.world.transport
        message = transport.last_latched(f"/{transport.node_name.lstrip('/')}/recent_log")
        return [
            (entry.msg, entry.level, entry.count, entry.stamp.to_sec()) for entry in message.entries
        ]

    def texts(self):
        return [text for text, *_ in self.entries()]


@pytest.fixture
def server(files, monkeypatch):
    monkeypatch.setattr(RealTimeTimer, "check_update", lambda timer: True)
    logger = logging.getLogger("test_recent_log")
    logger.propagate = False
    yield Server(files, logger)
    logger.handlers.clear()


def test_warnings_are_kept_from_the_first_on_and_counted(server):
    for _ in range(2):
        server.logger.error("an error in %s", "r2")
    server.logger.info("all is well")
    server.logger.warning("a warning")
    server.logger.error("an error in r2")

    assert server.entries() == [
        ("before there was a world", 4, 1, 0.0),
        ("a warning", 4, 1, 0.0),
        ("an error in r2", 8, 3, 0.0),
    ]


def test_the_recent_log_is_bounded(server):
    for number in range(1000):
        server.logger.warning("%d: %s", number, "x" * 100_000)
    server.logger.error("%s ValueError: the end", "y" * 100_000)

    texts = server.texts()
    assert len(texts) == 100
    assert texts[0].startswith("901: xxx")
    assert max(map(len, texts)) < 2100
    assert texts[-1].startswith("yyy")
    assert texts[-1].endswith(" ValueError: the end")


def test_warnings_go_with_the_model_that_they_name(server):
    server.logger.warning('the model "a" overlaps the layer "walls"')
    server.logger.warning("aa is another")
    server.tick()
    server.world.delete_model("a")

    assert server.texts() == ["aa is another"]


def test_reloading_the_files_removes_their_old_warnings(server):
    server.logger.warning("of the former files")
    server.manager.reset()
    assert "of the former files" in server.texts()

    config = server.world.read_config()
    server.logger.warning("of the new files")
    server.manager.reload(config)

    assert server.texts() == ["of the new files"]
