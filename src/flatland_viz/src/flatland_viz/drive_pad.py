"""A pad to drive by dragging: up is forwards, to the sides are turns."""

from typing import Any

from python_qt_binding.QtCore import QPoint, QPointF, QRectF, QSize, Qt, Signal
from python_qt_binding.QtGui import QColor, QPainter, QPalette, QPen
from python_qt_binding.QtWidgets import QSizePolicy, QWidget

_SIDE = 150
_KNOB = 15.0
_MARGIN = _KNOB + 3.0
_REST = 0.06  # part of the reach within which a knob snaps to an axis


def part_of(distance: float, reach: float) -> float:
    """A distance as a part of the reach, cut to [-1, 1]; 0 near the middle."""
    part = max(-1.0, min(1.0, distance / reach))
    return 0.0 if abs(part) < _REST else part


class DrivePad(QWidget):
    """A square with a knob that springs back. It also shows the command of keys."""

    moved = Signal(float, float)
    """Right and up, from -1 to 1; zeros when the mouse is released."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("drive_pad")
        self.setFocusPolicy(Qt.StrongFocus)
        self.setSizePolicy(QSizePolicy.Fixed, QSizePolicy.Fixed)
        self.setCursor(Qt.OpenHandCursor)
        self.setToolTip("Drag to drive: up is forwards. The robot stops when you let go.")
        self._right = self._up = 0.0
        self._is_dragged = False
        self._middle = QPoint()
        """The pad's middle on the screen when a drag began; a notice above may move the pad."""

    def sizeHint(self) -> QSize:  # noqa: N802
        """Its fixed size."""
        return QSize(_SIDE, _SIDE)

    def show_knob(self, right: float, up: float) -> None:
        """Moves the knob."""
        if (right, up) != (self._right, self._up):
            self._right, self._up = right, up
            self.update()

    def release(self) -> None:
        """Ends a drag, as if the mouse had been released."""
        if self._is_dragged:
            self._is_dragged = False
            self.setCursor(Qt.OpenHandCursor)
            self.moved.emit(0.0, 0.0)

    def mousePressEvent(self, event: Any) -> None:  # noqa: N802
        """Begins a drag."""
        if event.button() == Qt.LeftButton:
            self._is_dragged = True
            self._middle = self.mapToGlobal(QPoint(_SIDE // 2, _SIDE // 2))
            self.setCursor(Qt.ClosedHandCursor)
            self._drag(event.globalPos())

    def mouseMoveEvent(self, event: Any) -> None:  # noqa: N802
        """Follows the mouse, also beyond the pad."""
        if self._is_dragged:
            self._drag(event.globalPos())

    def mouseReleaseEvent(self, event: Any) -> None:  # noqa: N802
        """Ends a drag."""
        if event.button() == Qt.LeftButton:
            self.release()

    def _drag(self, place: QPoint) -> None:
        reach = _SIDE / 2 - _MARGIN
        right, down = place.x() - self._middle.x(), place.y() - self._middle.y()
        self.moved.emit(part_of(right, reach), part_of(-down, reach))

    def paintEvent(self, event: Any) -> None:  # noqa: N802
        """Draws the square, its axes and the knob."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.Antialiasing)
        colors = self.palette()
        group = QPalette.Normal if self.isEnabled() else QPalette.Disabled
        line = colors.color(group, QPalette.Mid)
        painter.setPen(QPen(line, 1.0))
        painter.setBrush(colors.color(group, QPalette.Base))
        painter.drawRoundedRect(QRectF(0.5, 0.5, _SIDE - 1, _SIDE - 1), 6, 6)
        middle, reach = _SIDE / 2, _SIDE / 2 - _MARGIN
        painter.setPen(QPen(line, 1.0, Qt.DotLine))
        painter.drawLine(QPointF(middle, _MARGIN), QPointF(middle, _SIDE - _MARGIN))
        painter.drawLine(QPointF(_MARGIN, middle), QPointF(_SIDE - _MARGIN, middle))
        knob = QPointF(middle + reach * self._right, middle - reach * self._up)
        is_active = self._right != 0.0 or self._up != 0.0
        color = QColor("#3c82c4") if self.isEnabled() else line
        painter.setPen(QPen(color, 3.0))
        if is_active:
            painter.drawLine(QPointF(middle, middle), knob)
        painter.setPen(QPen(color.darker(150), 1.5))
        painter.setBrush(color)
        painter.drawEllipse(knob, _KNOB, _KNOB)
