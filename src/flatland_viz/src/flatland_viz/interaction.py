"""The tools with which models are selected, dragged and spawned, for the window."""

import json
from typing import Any, Dict, NamedTuple, Tuple

from python_qt_binding.QtCore import QObject, Signal

from flatland_viz.selection import Selection


class Spawned(NamedTuple):
    """A model that was spawned, or that could be spawned again."""

    name: str
    namespace: str
    file: str
    pose: Tuple[float, float, float]
    """x, y [m] and yaw [rad]."""


class Interaction(QObject):
    """Connects the tools with the window's selection.

    Args:
        tool: rviz's tool flatland_viz/Interact.
        spawn_tool: flatland_viz/SpawnModel; None without it.
        selection: follows the tool, and the tool follows it.
    """

    state_changed = Signal(object)
    """Pose and velocity of the selected model, a few times a second: `x`, `y`, `theta`, `vx`,
    `vy`, `omega`; empty if they are unknown."""
    moved = Signal(str, object, object)
    """The user has dragged a model: its name, its former pose and the new one (x, y, yaw)."""
    spawned = Signal(object)
    """The user has spawned a model: a `Spawned`."""
    menu_asked = Signal(str)
    """The user asks for the context menu of this model."""

    def __init__(self, tool: Any, spawn_tool: Any, selection: Selection) -> None:
        super().__init__()
        properties = tool.getPropertyContainer()
        self._selected, self._state, self._moved, self._menu = (
            properties.subProp(name) for name in ("Selected", "State", "Moved", "Menu")
        )
        self.handles = properties.subProp("Handles")
        self._selection = selection
        self._selected.changed.connect(self._on_selected)
        self._state.changed.connect(lambda: self.state_changed.emit(self.state))
        self._moved.changed.connect(self._on_moved)
        self._menu.changed.connect(self._on_menu)
        selection.changed.connect(self._selected.setValue)
        self._spawned = None
        if spawn_tool is not None:
            self._spawned = spawn_tool.getPropertyContainer().subProp("Spawned")
            self._spawned.changed.connect(self._on_spawned)

    @property
    def state(self) -> Dict[str, Any]:
        """The last state; see `state_changed`."""
        state: Dict[str, Any] = _from_json(self._state.getValue())
        return state if state.get("name") == self._selection.name else {}

    def _on_selected(self) -> None:
        self._selection.select(self._selected.getValue())

    def _on_moved(self) -> None:
        moved = _from_json(self._moved.getValue())
        if moved:
            to = moved["to"]
            former = (moved["x"], moved["y"], moved["theta"])
            self.moved.emit(moved["name"], former, (to["x"], to["y"], to["theta"]))

    def _on_spawned(self) -> None:
        assert self._spawned is not None
        spawned = _from_json(self._spawned.getValue())
        if spawned:
            pose = (spawned["x"], spawned["y"], spawned["theta"])
            model = Spawned(spawned["name"], spawned["ns"], spawned["file"], pose)
            self._selection.select(model.name)
            self.spawned.emit(model)

    def _on_menu(self) -> None:
        name = self._menu.getValue()
        if name:
            self.menu_asked.emit(name)


def _from_json(text: str) -> Any:
    return json.loads(text) if text else {}
