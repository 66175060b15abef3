"""~recent_log: the server's last warnings and errors, for windows that open later.

`/rosout` has no history. Equal messages are one entry, with their number. An entry goes when a
world is read again without it, or when the model that it names is gone.
"""

import logging
import re
import threading
import time
from typing import Any, Dict, NamedTuple, Optional, Set

from flatland_server.messages import ros_time
from flatland_server.messages.message_types import get
from flatland_server.real_time_timer import RealTimeTimer
from flatland_server.simulation.simulation_manager import SimulationManager
from flatland_server.transport.transport import Publisher

LogEntry = get("flatland_msgs/LogEntry")
RecentLogMsg = get("flatland_msgs/RecentLog")

_MOST = 100  # entries
_LONGEST = 2000  # characters of a message
_PERIOD = 0.5  # s of real time between two messages
_LEVELS = {logging.WARNING: 4, logging.ERROR: 8}
_FATAL = 16


class _Entry(NamedTuple):
    time: float  # s of time.monotonic
    stamp: Any
    level: int
    times: int


class RecentLog(logging.Handler):
    """Collects warnings and errors, from any thread, and publishes them, latched."""

    def __init__(self, logger: logging.Logger) -> None:
        super().__init__(logging.WARNING)
        self._entries: Dict[str, _Entry] = {}  # by their texts, the latest last
        self._entries_lock = threading.Lock()
        self._has_changed = True
        self._timer = RealTimeTimer(_PERIOD)
        self._names: Set[str] = set()
        self._read_at = 0.0
        self._manager: Optional[SimulationManager] = None
        self._publisher: Optional[Publisher] = None
        logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Adds a message, or counts it."""
        text = self.format(record)
        if len(text) > _LONGEST:  # a traceback ends with its error
            text = f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 2 :]}"
        now = self._manager.timekeeper.nanoseconds if self._manager is not None else 0
        level = _LEVELS.get(record.levelno, _FATAL)
        with self._entries_lock:
            former = self._entries.pop(text, None)
            times = former.times + 1 if former is not None else 1
            self._entries[text] = _Entry(time.monotonic(), ros_time(now), level, times)
            if len(self._entries) > _MOST:
                del self._entries[next(iter(self._entries))]
            self._has_changed = True

    def open(self, manager: SimulationManager) -> None:
        """Opens the topic."""
        self._manager = manager
        self._publisher = manager.transport.advertise(
            f"{manager.transport.node_name}/recent_log", RecentLogMsg, latch=True, queue_size=1
        )

    def update(self) -> None:
        """Publishes entries that have changed, at a limited rate."""
        if not self._timer.check_update():
            return
        assert self._manager is not None
        assert self._publisher is not None
        world = self._manager.world
        gone, self._names = self._names - set(world.models), set(world.models)
        read_at, self._read_at = self._read_at, world.config.read_at
        if gone or read_at != self._read_at:
            self._forget(gone)
        with self._entries_lock:
            has_changed, self._has_changed = self._has_changed, False
            entries = list(self._entries.items()) if has_changed else []
        if has_changed:
            self._publisher.publish(
                RecentLogMsg(
                    [
                        LogEntry(entry.stamp, entry.level, text, entry.times)
                        for text, entry in entries
                    ]
                )
            )

    def _forget(self, gone: Set[str]) -> None:
        """Forgets messages of before the world's files were read, and those that name a model."""
        names = [name.split("/") for name in gone]
        with self._entries_lock:
            for text, entry in list(self._entries.items()):
                words = {*re.findall(r"\w+", text)}
                if entry.time < self._read_at or any(words.issuperset(name) for name in names):
                    del self._entries[text]
                    self._has_changed = True
