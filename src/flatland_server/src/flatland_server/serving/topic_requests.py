"""Requests that clients publish on a topic, where a service would answer them."""

import logging
from typing import Any, Callable

from flatland_server.exceptions import FlatlandError
from flatland_server.messages.message_types import get
from flatland_server.serving.client_files import told
from flatland_server.transport.transport import Transport

logger = logging.getLogger(__name__)


def obey(transport: Transport, topic: str, kind: str, action: Callable[[Any], None]) -> None:
    """Subscribes to a topic of requests. An error is a warning, once for equal ones in a row.

    Args:
        transport: of the server.
        topic: such as "move_model".
        kind: the message type, such as "flatland_msgs/MoveModelMsg".
        action: called with each message, between two steps.
    """
    name = transport.resolve(topic)
    last_warning = ""

    def receive(message: Any) -> None:
        nonlocal last_warning
        warning = ""
        try:
            action(message)
        except (FlatlandError, ValueError) as error:
            warning = told(error)
            if warning != last_warning:
                logger.warning("%s: %s", name, warning)
        last_warning = warning

    transport.subscribe(topic, get(kind), receive)
