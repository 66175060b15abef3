"""Names the plugin that holds up the simulation."""

import logging
import sys
import threading
import time
import weakref
from types import FrameType
from typing import Optional

from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_on_stack import describe_running, running_plugin

LIMIT = 1.0
"""Real time that a plugin may run before it is named in a warning [s]."""

logger = logging.getLogger(__name__)


class SlowPluginWatch:
    """Warns, once for each plugin, when a hook or callback of it takes longer than `LIMIT`.

    If the simulation's thread has not called `update` for some time, another thread looks at its
    stack. Hooks are not timed, as this would take longer than many of them. A plugin is named when
    it is found twice in a row: many quick plugins may also make a slow step.

    Create it on the simulation's thread.
    """

    def __init__(self) -> None:
        self._simulation = threading.get_ident()
        self._latest = time.monotonic()
        self._suspect: Optional[weakref.ref[Plugin]] = None
        self._warned: weakref.WeakSet[Plugin] = weakref.WeakSet()
        threading.Thread(target=self._watch, name="slow plugins", daemon=True).start()

    def update(self) -> None:
        """To be called at least once in `LIMIT / 2` while no plugin runs."""
        self._latest = time.monotonic()

    def _watch(self) -> None:
        while True:
            time.sleep(LIMIT / 2)
            self._look(sys._current_frames().get(self._simulation), time.monotonic())

    def _look(self, frame: Optional[FrameType], now: float) -> None:
        """Warns of the plugin that runs on a stack, if it already did half a `LIMIT` ago."""
        seconds = now - self._latest
        plugin = running_plugin(frame) if seconds >= LIMIT / 2 else None
        is_suspect = self._suspect is not None and self._suspect() is plugin
        self._suspect = weakref.ref(plugin) if plugin is not None else None
        if plugin is None or not is_suspect or seconds < LIMIT or plugin in self._warned:
            return
        self._warned.add(plugin)
        logger.warning(
            "the simulation has been held up for more than %g s by %s",
            LIMIT,
            describe_running(frame),
        )
