"""The Drive panel: a robot is driven by keys."""

from typing import Any, Dict, List, Optional, Set, Tuple

from python_qt_binding.QtCore import QEvent, QLocale, QObject, QSignalBlocker, Qt
from python_qt_binding.QtGui import QValidator
from python_qt_binding.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QDoubleSpinBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QScrollArea,
    QTextEdit,
    QVBoxLayout,
    QWidget,
)

from flatland_teleop.driving_keys import DIRECTIONS, HELP, Command, command
from flatland_viz.drive_publisher import DrivePublisher
from flatland_viz.model_list import Model
from flatland_viz.selection import Selection
from flatland_viz.settings import Settings

_KEYS: Dict[int, str] = {getattr(Qt, f"Key_{key.capitalize()}"): key for key in DIRECTIONS}
"""The names of Qt's keys that drive."""
_SPEED, _TURN = "drive/speed", "drive/turn"
_TYPING = (QLineEdit, QAbstractSpinBox, QTextEdit, QAbstractItemView)
"""Widgets that take the keys themselves."""
_AWAY = (QEvent.FocusOut, QEvent.Hide, QEvent.Close)
_WARNING = "background: #fdf1cf; color: #5b4300; border-radius: 3px; padding: 4px"


class NumberField(QDoubleSpinBox):
    """A field for a number, with a decimal point in every locale, as in world files.

    A comma becomes a point. A QDoubleSpinBox reads "1.5" as 15 in locales with a decimal comma: the
    point separates groups of digits there. In others it drops a comma, with the same result.
    """

    def __init__(self, name: str) -> None:
        super().__init__(objectName=name)
        self.setLocale(QLocale.c())

    def validate(self, text: str, cursor: int) -> Tuple[QValidator.State, str, int]:
        """Checks what is typed."""
        state, text, cursor = super().validate(text.replace(",", "."), cursor)
        return state, text, cursor


class DrivePanel(QDockWidget):
    """Drives a robot while keys are held, and stops it when they are released.

    Keys work in the whole window while the panel is open. The robot stops, too, when the window
    loses the keyboard and when the panel is closed.

    Args:
        selection: selection; the selected robot is driven.
        settings: settings, which keep the speeds.
    """

    def __init__(self, selection: Selection, settings: Settings) -> None:
        super().__init__("&Drive")
        self.setWindowTitle("Drive")
        self.toggleViewAction().setShortcut("F4")
        self.toggleViewAction().setToolTip("Drive a robot by keys (F4)")
        self.setObjectName("panel_drive")
        self._settings = settings
        self._robots: Dict[str, Model] = {}
        self._held: Set[int] = set()
        self._is_slow = False
        self._publisher = DrivePublisher()
        self._publishers: Dict[str, List[str]] = {}
        self._filtered: Optional[QObject] = None
        self._build()
        self._choice.currentIndexChanged.connect(self._open)
        self.visibilityChanged.connect(lambda _: self._open())
        selection.changed.connect(self._choose)
        selection.drive_asked.connect(self._begin)
        self.toggleViewAction().triggered.connect(lambda is_on: self.raise_() if is_on else None)
        self.set_models({})

    def _build(self) -> None:
        self._choice = QComboBox(objectName="drive_robot")
        self._choice.setFocusPolicy(Qt.TabFocus)  # the keys go on driving after a click
        self._speed = self._spin_box(_SPEED, 0.5, 0.05, 20.0, " m/s")
        self._turn = self._spin_box(_TURN, 1.0, 0.1, 20.0, " rad/s")
        self._turn_label = QLabel("Turn")
        self._now = QLabel(objectName="drive_now")
        keys = QLabel("\n".join(f"{key}: {action}" for key, action in HELP))
        keys.setWordWrap(True)  # it must not widen the panel
        self._notice = QLabel(objectName="drive_notice", wordWrap=True)
        self._notice.hide()
        form = QFormLayout()
        form.addRow("Robot", self._choice)
        form.addRow("Speed", self._speed)
        form.addRow(self._turn_label, self._turn)
        form.addRow("Now", self._now)
        content = QWidget()
        layout = QVBoxLayout(content)
        layout.addWidget(self._notice)  # at the top: on a small screen, the bottom is hidden
        layout.addLayout(form)
        layout.addWidget(keys)
        layout.addStretch()
        area = QScrollArea()  # on a small screen
        area.setFrameShape(QScrollArea.NoFrame)
        area.setWidgetResizable(True)
        area.setWidget(content)
        self.setWidget(area)

    def _spin_box(
        self, key: str, default: float, step: float, limit: float, unit: str
    ) -> NumberField:
        box = NumberField(key.replace("/", "_"))
        box.setRange(step, limit)
        box.setSingleStep(step)
        box.setSuffix(unit)
        box.setValue(self._settings.number(key, default))
        box.valueChanged.connect(lambda value: self._settings.set_number(key, value))
        box.valueChanged.connect(lambda _: self._send())
        box.lineEdit().returnPressed.connect(self.setFocus)
        return box

    def start(self) -> None:
        """Takes the window's keys. To be called when the window is shown."""
        if self._filtered is None:
            self._filtered = self.window().windowHandle()
            self._filtered.installEventFilter(self)

    def stop(self) -> None:
        """Stops the robot, even while keys are held."""
        self._held.clear()
        self._is_slow = False
        self._send()

    @property
    def _robot(self) -> Optional[Model]:
        return self._robots.get(self._choice.currentText())

    def set_models(self, models: Dict[str, Model]) -> None:
        """Sets the models in the world."""
        before = self._choice.currentText()
        self._robots = {name: model for name, model in models.items() if model.command_topic}
        if before not in self._robots:
            self.stop()  # keys held now must not drive the next robot
        with QSignalBlocker(self._choice):
            self._choice.clear()
            self._choice.addItems(self._robots)
            self._choice.setCurrentIndex(max(0, self._choice.findText(before)))
        self.widget().setEnabled(bool(self._robots))
        self._open()

    def _choose(self, name: str) -> None:
        if name in self._robots:
            self._choice.setCurrentText(name)

    def _begin(self, name: str) -> None:
        """Opens the panel to drive a robot."""
        self._choose(name)
        self.show()
        self.raise_()
        self.setFocus()

    def _open(self) -> None:
        """Opens the topic of the robot, while the panel can be seen."""
        robot = self._robot if self.isVisible() else None
        topic = robot.command_topic if robot else ""
        if not topic:
            self.stop()
        self._publisher.open(topic)
        self._choice.setToolTip(f"{robot.name}\n{topic}" if robot else "")
        steers = robot is not None and robot.steers
        self._turn_label.setText("Steer" if steers else "Turn")
        self._turn.setSuffix(" rad" if steers else " rad/s")
        self._show_notice()
        self._send()

    def set_publishers(self, publishers: Dict[str, List[str]]) -> None:
        """Sets the other nodes that publish a topic, by topic."""
        self._publishers = publishers
        self._show_notice()

    def _show_notice(self) -> None:
        topic = self._robot.command_topic if self._robot else ""
        nodes = self._publishers.get(topic, [])
        text = ""
        if not self._robots:
            text = "No robot in this world can be driven."
        elif nodes:
            names = ", ".join(nodes)
            text = f"{names} publish{'es' if len(nodes) == 1 else ''} on {topic} too."
        self._notice.setText(text)
        self._notice.setStyleSheet(_WARNING if nodes else "")
        self._notice.setVisible(bool(text))

    def _send(self) -> None:
        """Commands the velocity of the keys that are held together."""
        held = (_KEYS[key] for key in self._held)
        self._publisher.command(
            command(held, self._speed.value(), self._turn.value(), self._is_slow)
        )
        now = Command(*(value + 0.0 for value in self._publisher.velocity))  # no "-0.00"
        sideways = f"  {now.y:+.2f} m/s sideways" if now.y else ""
        self._now.setText(f"{now.x:+.2f} m/s{sideways}  {now.yaw:+.2f}{self._turn.suffix()}")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        """Takes the keys of the window while the panel is open."""
        kind = event.type()
        if kind in (QEvent.KeyPress, QEvent.KeyRelease):
            return self._take_key(event, kind == QEvent.KeyPress)
        if kind in _AWAY:
            self.stop()
        return False

    def _take_key(self, event: Any, is_press: bool) -> bool:
        """Returns whether the key is for driving."""
        if event.key() == Qt.Key_Shift:
            self._is_slow = is_press
            self._send()
            return False
        if event.key() not in _KEYS or not self.isVisible():
            return False
        is_for_others = bool(event.modifiers() & (Qt.ControlModifier | Qt.AltModifier))
        is_for_others |= isinstance(QApplication.focusWidget(), _TYPING)
        if is_press and (is_for_others or not self._robots):
            return False
        if not is_press and event.key() not in self._held and not event.isAutoRepeat():
            return False
        if not event.isAutoRepeat():
            self._is_slow = bool(event.modifiers() & Qt.ShiftModifier)
            (self._held.add if is_press else self._held.discard)(event.key())
            self._send()
        return True
