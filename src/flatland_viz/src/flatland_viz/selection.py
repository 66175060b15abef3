"""The selected model of the window, shared by the view, the panels and the menus."""

from python_qt_binding.QtCore import QObject, Signal


class Selection(QObject):
    """One model is selected, or none."""

    changed = Signal(str)
    """The name of the model that is selected now; empty if none is."""
    drive_asked = Signal(str)
    """The user asks to drive the model with this name."""

    def __init__(self) -> None:
        super().__init__()
        self._name = ""

    @property
    def name(self) -> str:
        """The name of the selected model; empty if none is."""
        return self._name

    def select(self, name: str) -> None:
        """Selects the model with this name; the empty string selects none."""
        if name != self._name:
            self._name = name
            self.changed.emit(name)
