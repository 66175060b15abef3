"""The time until which steps can be made without calling plugins."""

import math

_FOREVER = 2**63
"""A time that is never reached [ns]; an int, since ints are compared faster with ints."""


class StepPlan:
    """The simulated time before which no hook of a plugin is to be called.

    The `Schedule` makes it, keeps `until` up to date while plugins are called, and drops it
    when their timers change; the `PluginManager` drops it when plugins are added or removed. It is
    valid only as long as the subscribers are the same.

    Attributes:
        until: the time [ns] of the next step that calls a hook; 0 if each step may call one.
        subscriber_revision: of the transport when the plan was made; None if it has expired.
    """

    __slots__ = ("subscriber_revision", "until")

    def __init__(self) -> None:
        self.until = 0
        self.subscriber_revision: object = None

    def extend(self, until: float) -> None:
        """Extends the plan to another time [ns]; infinity if no hook is to be called."""
        self.until = math.ceil(until) if until < _FOREVER else _FOREVER

    def expire(self) -> None:
        """Drops the plan: something that it depends on has changed."""
        self.until = 0
        self.subscriber_revision = None
