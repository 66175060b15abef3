"""The tools with which models are selected, dragged and spawned, for the window."""

import json
from typing import Any, Dict

from python_qt_binding.QtCore import QObject, Signal

from flatland_viz.selection import Selection


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
    edited = Signal()
    """The user has dragged or spawned a model."""
    menu_asked = Signal(str)
    """The user asks for the context menu of this model."""

    def __init__(self, tool: Any, spawn_tool: Any, selection: Selection) -> None:
        super().__init__()
        properties = tool.getPropertyContainer()
        self._selected, self._state, self._dragged, self._menu = (
            properties.subProp(name) for name in ("Selected", "State", "Dragged", "Menu")
        )
        self.handles = properties.subProp("Handles")
        self._selection = selection
        self._selected.changed.connect(self._on_selected)
        self._state.changed.connect(lambda: self.state_changed.emit(self.state))
        self._dragged.changed.connect(self._on_dragged)
        self._menu.changed.connect(self._on_menu)
        selection.changed.connect(self._selected.setValue)
        self._spawned = None
        if spawn_tool is not None:
            self._spawned = spawn_tool.getPropertyContainer().subProp("Spawned")
            self._spawned.changed.connect(self._on_spawned)

    @property
    def state(self) -> Dict[str, Any]:
        """The last state; see `state_changed`."""
        text = self._state.getValue()
        state: Dict[str, Any] = json.loads(text) if text else {}
        return state if state.get("name") == self._selection.name else {}

    def _on_selected(self) -> None:
        self._selection.select(self._selected.getValue())

    def _on_dragged(self) -> None:
        if self._dragged.getValue():
            self.edited.emit()

    def _on_spawned(self) -> None:
        assert self._spawned is not None
        name = self._spawned.getValue()
        if name:
            self._selection.select(name)
            self.edited.emit()

    def _on_menu(self) -> None:
        name = self._menu.getValue()
        if name:
            self.menu_asked.emit(name)
