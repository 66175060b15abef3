"""Errors of what is done for clients."""

import logging
from typing import Any, Callable, Set, Tuple

logger = logging.getLogger(__name__)


class Failures:
    """Keeps errors from ending the simulation. Each kind is logged once."""

    def __init__(self) -> None:
        self._kinds: Set[Tuple[str, str]] = set()

    def catch(self, function: Callable[..., object], *arguments: Any) -> None:
        """Calls a function.

        Args:
            function: function to call; it may raise any exception.
            arguments: arguments of the call.
        """
        try:
            function(*arguments)
        except Exception as error:
            name = getattr(function, "__qualname__", repr(type(function)))
            kind = name, type(error).__name__
            if kind not in self._kinds:
                self._kinds.add(kind)
                logger.exception("%s has failed; the simulation goes on", name)
