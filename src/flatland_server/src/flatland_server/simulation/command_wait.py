"""Waiting for the commands of controllers that fall behind simulated time."""

import logging
from typing import Callable, Optional

from flatland_server.transport.arrivals import Arrivals

logger = logging.getLogger(__name__)

_PATIENCE = 1.0
"""Real time after which a controller without a command is no longer waited for [s]."""


class CommandWait:
    """Tells when the simulation is to wait, since a controller's last command is too old.

    A controller is waited for from its first command on. One that sends none for a second of real
    time has ended or has no goal: it is waited for again from its next command on.

    Args:
        arrivals: arrivals of messages on the transport.
        steps: the age of a command from which on the simulation waits for the next one.
        clock: returns the real time [s].
    """

    def __init__(self, arrivals: Arrivals, steps: int, clock: Callable[[], float]) -> None:
        self._arrivals = arrivals
        self._steps = steps
        self._clock = clock
        self._since: Optional[float] = None

    def is_due(self, is_stepping: bool) -> bool:
        """True if the next step has to wait.

        Args:
            is_stepping: whether steps are made at all; during a pause, no controller is late.
        """
        newest = self._arrivals.step - self._steps
        late = [each for each in self._arrivals.commands if 0 <= each.step <= newest]
        if not late or not is_stepping:
            self._since = None
            return False
        now = self._clock()
        if self._since is None:
            self._since = now
        if now - self._since < _PATIENCE:
            return True
        for each in late:
            logger.info("no command on %s for %g s: not waited for", each.topic, _PATIENCE)
            each.forget()
        return False
