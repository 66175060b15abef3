"""Names the plugin that holds up the simulation."""

import logging
import sys
import threading
import time
import weakref

from flatland_server.plugins.plugin import Plugin
from flatland_server.plugins.plugin_on_stack import describe_running, running_plugin

LIMIT = 1.0
"""Real time that a plugin may run before it is named in a warning [s]."""

logger = logging.getLogger(__name__)


class SlowPluginWatch:
    """Warns, once for each plugin, when a hook or callback of it takes longer than `LIMIT`.

    A thread looks at what the simulation's thread is running when that has not called `update` for
    so long. Hooks themselves are not timed, which would take longer than many of them do.

    To be made on the simulation's thread.
    """

    def __init__(self) -> None:
        self._simulation = threading.get_ident()
        self._latest = time.monotonic()
        self._warned: weakref.WeakSet[Plugin] = weakref.WeakSet()
        threading.Thread(target=self._watch, name="slow plugins", daemon=True).start()

    def update(self) -> None:
        """To be called at least once in `LIMIT` while no plugin runs."""
        self._latest = time.monotonic()

    def _watch(self) -> None:
        while True:
            time.sleep(LIMIT / 2)
            if time.monotonic() - self._latest >= LIMIT:
                self._warn()

    def _warn(self) -> None:
        frame = sys._current_frames().get(self._simulation)
        plugin = running_plugin(frame)
        if plugin is not None and plugin not in self._warned:
            self._warned.add(plugin)
            logger.warning(
                "the simulation has been held up for more than %g s by %s",
                LIMIT,
                describe_running(frame),
            )
