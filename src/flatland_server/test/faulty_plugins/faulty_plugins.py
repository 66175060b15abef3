"""Plugins that fail, for server.test and test_launch.py."""

import logging

from std_msgs.msg import Empty

from flatland_server.plugins.model_plugin import ModelPlugin

logger = logging.getLogger(__name__)


class FailsToStart(ModelPlugin):
    """Raises when it is started, after it has opened a topic."""

    def on_initialize(self, config):
        self.node.advertise("fails_to_start", Empty)
        raise RuntimeError("no battery")


class FailsLater(ModelPlugin):
    """Raises in its hook after a message; logs an error if it is called again."""

    def on_initialize(self, config):
        self._publisher = self.node.advertise("alive", Empty)
        self.node.subscribe("fail", Empty, self._on_fail)
        self._is_to_fail = self._has_failed = False

    def _on_fail(self, message):
        self._is_to_fail = True

    def before_physics_step(self, timekeeper):
        if self._has_failed:
            logger.error("a plugin that has failed is called again")
        if self._is_to_fail:
            self._has_failed = True
            raise RuntimeError("the battery is empty")
        self._publisher.publish(Empty())


class NeverReturns(ModelPlugin):
    """Has an endless loop in its hook after three seconds."""

    def on_initialize(self, config):
        pass

    def before_physics_step(self, timekeeper):
        while timekeeper.seconds > 3.0:
            pass
