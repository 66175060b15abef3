"""The selected model of the window, shared by the view, the panels and the menus."""

from typing import Any, Dict

from python_qt_binding.QtCore import QObject, Signal


class Selection(QObject):
    """One model is selected, or none, by the tools of the view or by a panel."""

    changed = Signal(str)
    """The name of the model that is selected now; empty if none is."""
    drive_asked = Signal(str)
    """The user asks to drive the model with this name."""
    state_changed = Signal()
    """`state` is another one: a few times a second."""
    edited = Signal()
    """The user has dragged or spawned a model."""
    menu_asked = Signal()
    """The user asks for the context menu of the selected model."""

    def __init__(self) -> None:
        super().__init__()
        self.name = ""
        """The name of the selected model; empty if none is."""
        self._state: Dict[str, Any] = {}

    def select(self, name: str) -> None:
        """Selects the model with this name; the empty string selects none."""
        if name != self.name:
            self.name = name
            self.changed.emit(name)

    @property
    def state(self) -> Dict[str, Any]:
        """Pose and velocity of the selected model: `x`, `y`, `theta`, `vx`, `vy`, `omega`.

        Empty if they are unknown.
        """
        return self._state if self._state.get("name") == self.name else {}

    def set_state(self, state: Dict[str, Any]) -> None:
        """Sets the state, with the `name` of its model."""
        self._state = state
        self.state_changed.emit()

    def follow_tools(self, interact: Any, spawn: Any) -> None:
        """Follows rviz's tools with which models are selected, dragged and spawned.

        Args:
            interact: flatland_viz/Interact, which follows this selection.
            spawn: flatland_viz/SpawnModel.
        """
        tool = interact.getPropertyContainer()
        selected, state, dragged, menu = (
            tool.subProp(name) for name in ("Selected", "State", "Dragged", "Menu")
        )
        spawned = spawn.getPropertyContainer().subProp("Spawned")
        # Only referenced by slots of their own, they would be garbage to Python.
        self._properties = (selected, state, dragged, menu, spawned)
        self.changed.connect(selected.setValue)
        selected.changed.connect(lambda: self.select(selected.getValue()))
        state.changed.connect(lambda: self.set_state(state.getValue()))
        dragged.changed.connect(lambda: self.edited.emit() if dragged.getValue() else None)
        menu.changed.connect(lambda: self.menu_asked.emit() if menu.getValue() else None)
        spawned.changed.connect(lambda: self._on_spawned(spawned.getValue()))

    def _on_spawned(self, name: str) -> None:
        if name:
            self.select(name)
            self.edited.emit()
