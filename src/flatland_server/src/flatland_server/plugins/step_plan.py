"""Until when steps can be made without a look at the plugins."""

import math

_FOREVER = 2**63
"""A time that is never reached [ns]; an int, since ints are compared faster with ints."""


class StepPlan:
    """The simulated time before which no hook of a plugin is to be called.

    The `Schedule` makes it, keeps `until` up to date while plugins are called, and lets it expire
    when their timers change; the `PluginManager` does so when plugins come or go. It does not hold
    for other subscribers.

    Attributes:
        until: the time [ns] of the next step that calls a hook; 0 if each step may call one.
        subscriber_revision: of the transport when the plan was made; None if it has expired.
    """

    __slots__ = ("subscriber_revision", "until")

    def __init__(self) -> None:
        self.until = 0
        self.subscriber_revision: object = None

    def extend(self, until: float) -> None:
        """From now on it holds until another time [ns]; infinity if no hook is to be called."""
        self.until = math.ceil(until) if until < _FOREVER else _FOREVER

    def expire(self) -> None:
        """Drops the plan: something that it depends on has changed."""
        self.until = 0
        self.subscriber_revision = None
