"""The states of plugins, as parts of the state of a world."""

from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from flatland_server import plain_data
from flatland_server.exceptions import PLUGIN_ERRORS, StateError
from flatland_server.plugins.plugin import Plugin, plugin_label
from flatland_server.plugins.plugin_manager import PluginFailure, PluginManager
from flatland_server.update_timer import UpdateTimer


@dataclass(frozen=True)
class PluginState:
    """A plugin: `state` is from its `get_state`, the other attributes are the framework's."""

    owner: str
    """The name of its model; empty for a plugin of the world."""
    name: str
    type: str
    failure: Optional[str]
    """The reason why it was switched off; None if it runs."""
    rng: Dict[str, Any]
    """The state of its generator; empty: it starts from scratch."""
    timer: Optional[Dict[str, Any]]
    state: Any

    @classmethod
    def of(cls, owner: str, plugin: Plugin, failure: Optional[str]) -> "PluginState":
        """The present state of a plugin.

        Args:
            owner: the name of its model; empty for a plugin of the world.
            plugin: the plugin.
            failure: why it was switched off; None if it runs.

        Raises:
            StateError: its `get_state` raises an exception, or returns what is not plain data.
        """
        timer = plugin.update_timer
        state = cls(
            owner,
            plugin.name,
            plugin.type,
            failure,
            plugin.rng.bit_generator.state,  # type: ignore[arg-type]
            timer.get_state() if timer is not None else None,
            _call(plugin, "get_state", plugin.get_state) if failure is None else None,
        )
        _call(plugin, "get_state", lambda: plain_data.dumps(state.state))
        return state

    def restore(self, plugin: Plugin) -> None:
        """Puts a plugin that has just been initialized into this state.

        Raises:
            StateError: the state does not fit, or `set_state` raises an exception.
        """
        if plugin.type != self.type:
            raise StateError(
                f'the plugin "{plugin.node.owner}" is a {self.type} in the state, here a '
                f"{plugin.type}"
            )

        def restore() -> None:
            if not self.rng:
                return
            plugin.rng.bit_generator.state = self.rng
            if self.timer is None:
                plugin.update_timer = None
            else:
                timer = plugin.update_timer or UpdateTimer()
                timer.set_state(self.timer)
                plugin.update_timer = timer  # it is queued for another time now
            if self.failure is None and has_state_hooks(plugin):
                plugin.set_state(self.state)

        _call(plugin, "set_state", restore)


def has_state_hooks(plugin: Plugin) -> bool:
    """True if a plugin overrides `get_state`."""
    return type(plugin).get_state is not Plugin.get_state


def collect(manager: PluginManager) -> List[PluginState]:
    """The states of all plugins.

    Raises:
        StateError: one of them cannot be saved.
    """
    states = []
    for owner, plugin in manager.all_plugins():
        failure = manager.failure_of(plugin)
        states.append(PluginState.of(owner, plugin, failure.reason if failure else None))
    return states


def completed(manager: PluginManager, states: Sequence[PluginState]) -> List[PluginState]:
    """The states of all plugins, given those of some."""
    known = {(state.owner, state.name): state for state in states}
    every = {
        (owner, plugin.name): PluginState(owner, plugin.name, plugin.type, None, {}, None, None)
        for owner, plugin in manager.all_plugins()
    }
    return list({**every, **known}.values())


def restore_failures(manager: PluginManager, states: Sequence[PluginState]) -> None:
    """Switches off the plugins that had failed.

    Call it before bodies get their places: it may move them.

    Raises:
        StateError: the states are not those of these plugins.
    """
    for plugin, state in _pairs(manager, states):
        if state.failure is not None:
            failure = PluginFailure(state.owner, state.name, state.type, state.failure)
            manager.switch_off(plugin, failure)


def restore(manager: PluginManager, states: Sequence[PluginState]) -> None:
    """Puts all plugins, which have just been initialized, into their states.

    Raises:
        StateError: the states do not fit.
    """
    for plugin, state in _pairs(manager, states):
        state.restore(plugin)


def _pairs(
    manager: PluginManager, states: Sequence[PluginState]
) -> List[Tuple[Plugin, PluginState]]:
    plugins = manager.all_plugins()
    expected = [(owner, plugin.name) for owner, plugin in plugins]
    if expected != [(state.owner, state.name) for state in states]:
        raise StateError(
            "the state is of another world: expected the plugins "
            f"{', '.join(plugin.node.owner for _, plugin in plugins)}; "
            f"found {', '.join(plugin_label(each.owner, each.name) for each in states)}"
        )
    return [(plugin, state) for (_, plugin), state in zip(plugins, states)]


def without_hooks(manager: PluginManager) -> List[str]:
    """The running plugins that do not override `get_state`, as `model/plugin`."""
    return [
        plugin.node.owner
        for _, plugin in manager.all_plugins()
        if not has_state_hooks(plugin) and manager.failure_of(plugin) is None
    ]


def _call(plugin: Plugin, name: str, function: Callable[[], Any]) -> Any:
    try:
        return function()
    except PLUGIN_ERRORS as error:
        reason = f"{type(error).__name__}: {error}"
        raise StateError(f'the plugin "{plugin.node.owner}": {name}: {reason}') from error
