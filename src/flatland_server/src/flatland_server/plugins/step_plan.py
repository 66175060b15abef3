"""Until when steps can be made without a look at the plugins."""

import math

from flatland_server.timekeeper import Timekeeper

_FOREVER = 2**63
"""A time that is never reached [ns]; an int, since ints are compared faster with ints."""

MOST_STEPS = 100
"""Of one call of the core; Python handles signals, such as Ctrl-C, between two calls."""


class StepPlan:
    """The simulated time before which no hook of a plugin is to be called.

    The `Schedule` makes it, and keeps `until` up to date while plugins are called. It expires when
    plugins or their timers change, and does not hold for other subscribers.

    Attributes:
        until: the time [ns] of the next step that calls a hook; 0 if each step may call one.
        subscriber_revision: of the transport when the plan was made; None if it has expired.
    """

    __slots__ = ("subscriber_revision", "until")

    def __init__(self) -> None:
        self.until = 0
        self.subscriber_revision: object = None

    def covers(self, timekeeper: Timekeeper, count: int) -> bool:
        """Whether a call of the core may make so many steps from now on, 1 or more."""
        last = timekeeper.nanoseconds + (count - 1) * timekeeper.step_nanoseconds
        return last < self.until and count <= MOST_STEPS

    def extend(self, until: float) -> None:
        """From now on it holds until another time [ns]; infinity if no hook is to be called."""
        self.until = math.ceil(until) if until < _FOREVER else _FOREVER

    def expire(self) -> None:
        """The plan is to be made anew: something that it depends on has changed."""
        self.until = 0
        self.subscriber_revision = None
