"""The status line: hints of the tools, and the state of the simulation."""

from html import escape
from typing import Any

from python_qt_binding.QtCore import QEvent, QSize, Qt, QTimer, Signal
from python_qt_binding.QtGui import QPalette
from python_qt_binding.QtWidgets import QLabel, QProgressBar, QStatusBar, QToolButton

from flatland_viz.labels import ElidedLabel
from flatland_viz.status import Status

_RUNNING = {"light": "color: #1a7f37", "dark": "color: #57c878"}
"""Style of the running state, by the desktop's colours."""
_STYLE = {
    "paused": "background: #0072b2; color: white",
    "no server": "background: #c62828; color: white",
}
_FOLLOWED = (
    "QToolButton { background: #009e73; color: white; border: 0; border-radius: 3px; "
    "padding: 1px 8px }"
)
_PLACED = (
    "<p>Nothing publishes a transform from map to {frames}. This window draws the robots at their "
    "true poses; other nodes do not know where they are. Start a localiser, or the server with "
    "map_to_odom:=true.</p>"
)
_MESSAGE_TIME = 10_000  # ms
_LEAST_HINT = 60  # pixels
_SPACE = 12  # pixels: margin of a field


class _Field(QLabel):
    """A label that is as wide as its widest text, or as its present one in a narrow window."""

    clicked = Signal()

    def __init__(self, width: int) -> None:
        super().__init__()
        self._width = width

    def mousePressEvent(self, event: Any) -> None:  # noqa: N802
        """Takes the mouse until the release."""

    def mouseReleaseEvent(self, event: Any) -> None:  # noqa: N802
        """Takes clicks, as a button does."""
        if event.button() == Qt.LeftButton and self.rect().contains(event.pos()):
            self.clicked.emit()

    def sizeHint(self) -> QSize:  # noqa: N802
        """The size in a window with enough room."""
        return super().sizeHint().expandedTo(QSize(self._width, 0))


class StatusLine(QStatusBar):
    """Hints at the left; at the right simulated time, speed and state."""

    rate_asked = Signal()
    """A click on the speed."""
    following_ended = Signal()
    """A click on the model that the view follows."""
    pause_asked = Signal()
    """A click on the state, to pause or to resume."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("status")
        self._hint = ElidedLabel(Qt.ElideRight, objectName="status_hint")
        self._hint.setMinimumWidth(_LEAST_HINT)
        self.addWidget(self._hint, 1)
        self._progress = QProgressBar(objectName="status_progress")
        self._progress.setMaximumSize(160, self.fontMetrics().height())
        self._progress.hide()
        self.addPermanentWidget(self._progress)
        self._followed = QToolButton(objectName="status_followed")
        self._followed.setStyleSheet(_FOLLOWED)
        self._followed.setToolTip("The view moves along with this model; click to end that (F)")
        self._followed.clicked.connect(self.following_ended)
        self._followed.hide()
        self.addPermanentWidget(self._followed)
        self._placed = QLabel("No map \u2192 odom", objectName="status_placed")
        self._placed.hide()
        self.insertPermanentWidget(1, self._placed)  # beside the hint: it comes and goes
        self._expiry = QTimer(self, singleShot=True, interval=_MESSAGE_TIME)
        self._expiry.timeout.connect(lambda: self._hint.show_line(""))
        self._time = self._field("status_time", "simulated time", "100000.000 s")
        self._speed = self._field(
            "status_speed", "simulated per real time; click to change it", "10.00 of 10 x"
        )
        self._state = self._field("status_state", "the simulation", "waiting for the server")
        self._state.setAlignment(Qt.AlignCenter)
        self._speed.setCursor(Qt.PointingHandCursor)
        self._speed.clicked.connect(self.rate_asked)
        self._state.clicked.connect(self._ask_for_pause)

    def _field(self, name: str, meaning: str, widest: str) -> _Field:
        """A label with a width that does not depend on its text, where there is room for it."""
        field = _Field(self.fontMetrics().horizontalAdvance(widest) + _SPACE)
        field.setObjectName(name)
        field.setToolTip(meaning)
        field.setAlignment(Qt.AlignRight | Qt.AlignVCenter)
        self.addPermanentWidget(field)
        return field

    def show_status(self, status: Status) -> None:
        """Shows the state of the simulation."""
        self._time.setText(status.time)
        self._speed.setText(status.speed)
        if status.state != self._state.text():
            self._state.setText(status.state)
            self._show_state()

    def _show_state(self) -> None:
        state = self._state.text()
        verb = {"running": "pause", "paused": "resume"}.get(state)
        self._state.setToolTip(f"click to {verb} (Space)" if verb else "the simulation")
        self._state.setCursor(Qt.PointingHandCursor if verb else Qt.ArrowCursor)
        self._state.setStyleSheet(self._style(state))

    def _ask_for_pause(self) -> None:
        if self._state.text() in ("running", "paused"):
            self.pause_asked.emit()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Shows the state in a colour for the other look of the window."""
        super().changeEvent(event)
        if event.type() == QEvent.PaletteChange:
            self._show_state()

    def _style(self, state: str) -> str:
        if state == "running":
            is_dark = self.palette().color(QPalette.Window).lightness() < 128
            return _RUNNING["dark" if is_dark else "light"]
        return _STYLE.get(state, "")

    def show_followed(self, name: str) -> None:
        """Shows which model the view follows; none if it is empty."""
        self._followed.setText(f"follows {name} \u2715")
        self._followed.setVisible(bool(name))

    def show_placed(self, frames: str) -> None:
        """Shows that robots are placed by their true poses; not if there are no such frames."""
        self._placed.setVisible(bool(frames))
        self._placed.setToolTip(_PLACED.format(frames=frames))

    def show_progress(self, what: str, percent: int) -> None:
        """Shows the progress of loading or drawing, until it is complete."""
        self._progress.setFormat(f"{what} %p %")
        self._progress.setValue(percent)
        self._progress.setVisible(percent < 100)

    def show_hint(self, hint: str) -> None:
        """Shows a hint until the next one; rviz's tools write it in rich text."""
        self._expiry.stop()
        self._hint.show_line(" ".join(hint.split()))

    def show_message(self, message: str) -> None:
        """Shows a message for some seconds."""
        self._hint.show_line(escape(message))
        self._expiry.start()
