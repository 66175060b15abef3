"""The dialog for a model's new pose."""

import math
from typing import Tuple

from python_qt_binding.QtWidgets import QDialog, QDialogButtonBox, QFormLayout, QWidget

from flatland_viz.number_field import NumberField

_FARTHEST = 1e5  # m


class MoveDialog(QDialog):
    """Asks for a pose.

    Args:
        parent: the dialog's parent.
        name: the model's name.
        pose: its present one: x, y [m], yaw [rad].
    """

    def __init__(self, parent: QWidget, name: str, pose: Tuple[float, float, float]) -> None:
        super().__init__(parent)
        self.setObjectName("move_to")
        self.setWindowTitle(f"Move {name}")
        self._x = self._field("x", pose[0], " m", _FARTHEST, 0.1)
        self._y = self._field("y", pose[1], " m", _FARTHEST, 0.1)
        self._yaw = self._field("yaw", math.degrees(pose[2]), "\u00b0", 360.0, 15.0)
        form = QFormLayout(self)
        form.addRow("&x", self._x)
        form.addRow("&y", self._y)
        form.addRow("&Yaw", self._yaw)
        buttons = QDialogButtonBox(QDialogButtonBox.Ok | QDialogButtonBox.Cancel)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        form.addRow(buttons)
        self._x.setFocus()
        self._x.selectAll()

    def _field(self, name: str, value: float, unit: str, limit: float, step: float) -> NumberField:
        field = NumberField(name)
        field.setRange(-limit, limit)
        field.setDecimals(1 if unit == "\u00b0" else 3)
        field.setSingleStep(step)
        field.setSuffix(unit)
        field.setValue(value)
        return field

    @property
    def pose(self) -> Tuple[float, float, float]:
        """The pose asked for: x, y [m], yaw [rad]."""
        return self._x.value(), self._y.value(), math.radians(self._yaw.value())
