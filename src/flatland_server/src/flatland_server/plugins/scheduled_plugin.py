"""The plugins in a schedule, and the calls of their hooks."""

from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Tuple

from flatland_server.plugins.plugin import STEP_HOOKS, Plugin
from flatland_server.timekeeper import Timekeeper
from flatland_server.update_timer import UpdateTimer

StepHook = Callable[[Timekeeper], None]


@dataclass(eq=False)
class ScheduledPlugin:
    """A plugin with the step hooks that it overrides, by name."""

    plugin: Plugin
    hooks: Dict[str, StepHook]
    order: int
    """Unique; plugins are called in this order, in which they were started."""
    timer: Optional[UpdateTimer] = None
    """When it is due; None if that is at every step."""
    is_removed: bool = False


class StepCalls:
    """The hooks to call in a step, in the order of the plugins.

    Args:
        plugins: those that are due in this step and have work, in their order.
    """

    def __init__(self, plugins: List[ScheduledPlugin]) -> None:
        self.plugins = plugins
        self.hooks: Dict[str, List[Tuple[ScheduledPlugin, StepHook]]] = {
            name: [(each, each.hooks[name]) for each in plugins if name in each.hooks]
            for name in STEP_HOOKS
        }
        """By the name of the hook."""
