"""The side panel: all models, and the details of the selected one."""

from html import escape
from pathlib import Path
from typing import Dict, List, Optional

from python_qt_binding.QtCore import QSignalBlocker, QSize, Qt, QTimer
from python_qt_binding.QtGui import QColor, QIcon, QKeySequence, QPainter, QPalette, QPixmap
from python_qt_binding.QtWidgets import (
    QDockWidget,
    QFormLayout,
    QFrame,
    QGridLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QScrollArea,
    QShortcut,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from flatland_viz.labels import ElidedLabel, SelectableLabel
from flatland_viz.model_actions import ModelActions
from flatland_viz.model_list import Model, Topic, sorted_topics
from flatland_viz.selection import Selection
from flatland_viz.topic_monitor import TopicMonitor
from flatland_viz.topic_tree import TopicTree
from flatland_viz.topic_values import position, velocity
from flatland_viz.world_files import label

_READ_PERIOD = 500  # ms
_WIDTH = 250
_BUTTON_COLUMNS = 3
_DOT, _MARGIN = 10, 4  # device-independent pixels
_SELECTED = QColor(70, 76, 84)
"""Background of the selected row: no robot has this colour."""


class ModelPanel(QDockWidget):
    """A list of the models, and the selected one's pose, speed, plugins, topics and actions."""

    def __init__(self, selection: Selection, actions: ModelActions) -> None:
        super().__init__("Models")
        self.setObjectName("panel_models")
        self.setFeatures(QDockWidget.DockWidgetClosable | QDockWidget.DockWidgetMovable)
        self._selection = selection
        self._models: Dict[str, Model] = {}
        self._colors: Dict[str, str] = {}
        self._time = 0.0
        self._monitor = TopicMonitor()
        self._list = QListWidget(objectName="model_list")
        self._search = QLineEdit(objectName="model_search", placeholderText="Search (Ctrl+F)")
        self._search.setClearButtonEnabled(True)
        self._search.setFocusPolicy(Qt.ClickFocus)  # keys without modifiers are the window's
        self._search.textChanged.connect(self._filter)
        self._search.returnPressed.connect(self._choose_first)
        QShortcut(QKeySequence.Find, self, self._search.setFocus)
        self._list.setUniformItemSizes(True)
        self._list.setTextElideMode(Qt.ElideMiddle)  # names of a fleet differ at their ends
        self._list.setIconSize(QSize(_DOT, _DOT))
        colors = self._list.palette()
        colors.setColor(QPalette.Highlight, _SELECTED)
        colors.setColor(QPalette.HighlightedText, Qt.white)
        self._list.setPalette(colors)
        self._details = _Details(actions)
        area = QScrollArea()  # on a small screen
        area.setFrameShape(QFrame.NoFrame)
        area.setWidgetResizable(True)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarAlwaysOff)
        area.setWidget(self._details)
        content = QWidget()
        column = QVBoxLayout(content)
        column.setContentsMargins(6, 4, 6, 6)
        column.addWidget(self._search)
        column.addWidget(self._list, 2)
        column.addWidget(area, 5)
        left, _, right, _ = column.getContentsMargins()
        bar = area.verticalScrollBar().sizeHint().width()
        content.setMinimumWidth(max(_WIDTH, self._details.least_width + left + right + bar))
        self.setWidget(content)
        self._list.currentItemChanged.connect(self._on_chosen)
        selection.changed.connect(lambda name: self._show_selected())
        selection.state_changed.connect(self._show_state)
        self._reader = QTimer(self)
        self._reader.timeout.connect(self._read_topics)
        self._reader.start(_READ_PERIOD)
        self.visibilityChanged.connect(lambda shown: self._watch())
        self._show_selected()

    def set_models(self, models: Dict[str, Model]) -> None:
        """Sets the models in the world, in natural order. Robots come first in the list."""
        self._models = models
        self._fill_list()
        self._show_selected()

    def set_colors(self, colors: Dict[str, str]) -> None:
        """Sets the robots' colours, as `#rrggbb` by name."""
        self._colors = colors
        self._fill_list()

    def set_time(self, time: float) -> None:
        """Sets the simulated time [s], from which rates are computed."""
        self._time = time

    def _fill_list(self) -> None:
        with QSignalBlocker(self._list):
            self._list.clear()
            for name in sorted(self._models, key=lambda name: name not in self._colors):
                item = QListWidgetItem(_dot(self._colors.get(name), self.devicePixelRatioF()), name)
                item.setToolTip(name)
                self._list.addItem(item)
                if name == self._selection.name:
                    self._list.setCurrentItem(item)
        self._filter()

    def _filter(self) -> None:
        """Shows the models with the text of the search in their names."""
        text = self._search.text().strip().casefold()
        for row in range(self._list.count()):
            self._list.setRowHidden(row, text not in self._list.item(row).text().casefold())

    def _choose_first(self) -> None:
        """Selects the first model that the search has found."""
        rows = range(self._list.count())
        found = next((row for row in rows if not self._list.isRowHidden(row)), None)
        if found is not None:
            self._selection.select(self._list.item(found).text())
        self._search.clearFocus()

    def _on_chosen(self, item: Optional[QListWidgetItem]) -> None:
        self._selection.select(item.text() if item is not None else "")

    def _show_selected(self) -> None:
        name = self._selection.name
        found = self._list.findItems(name, Qt.MatchExactly) if name else []
        with QSignalBlocker(self._list):
            self._list.setCurrentItem(found[0] if found else None)
        self._details.show_model(self._models.get(name))
        self._show_state()
        self._watch()

    def _show_state(self) -> None:
        state = self._selection.state
        self._details.show_pose(
            position(state["x"], state["y"], state["theta"]) if state else "",
            velocity(state["vx"], state["vy"], state["omega"]) if state else "",
        )

    def _watch(self) -> None:
        """Subscribes to the topics on display, and to none while the panel is hidden."""
        model = self._models.get(self._selection.name) if self.isVisible() else None
        self._monitor.watch(_shown_topics(model))
        self._read_topics()

    def _read_topics(self) -> None:
        if self.isVisible():
            self._details.topics.show_readings(self._monitor.readings(self._time))


class _Details(QWidget):
    """The details of one model."""

    def __init__(self, actions: ModelActions) -> None:
        super().__init__()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, _MARGIN, 0, 0)
        self._empty = QLabel("Click a model on the map or in the list.")
        self._empty.setWordWrap(True)
        self._empty.setAlignment(Qt.AlignTop | Qt.AlignLeft)
        self._content = QWidget()
        column.addWidget(self._empty, 1)
        column.addWidget(self._content, 1)
        rows = QVBoxLayout(self._content)
        rows.setContentsMargins(0, 0, 0, 0)
        self._name = ElidedLabel(Qt.ElideMiddle, objectName="model_name")
        font = self._name.font()
        font.setBold(True)
        font.setPointSizeF(1.15 * font.pointSizeF())
        self._name.setFont(font)
        rows.addWidget(self._name)
        self._buttons = _buttons(actions)
        rows.addLayout(self._buttons)
        self._form = QFormLayout()
        self._form.setLabelAlignment(Qt.AlignLeft | Qt.AlignTop)
        self._form.setHorizontalSpacing(10)
        self._form.setVerticalSpacing(3)
        self._pose = self._row("Pose", "model_pose")
        self._speed = self._row("Speed", "model_speed")
        self._namespace = self._row("Namespace", "model_namespace")
        self._file = self._row("File", "model_file")
        self._plugins = self._row("Plugins", "model_plugins")
        rows.addLayout(self._form)
        self.topics = TopicTree()
        rows.addWidget(self.topics, 1)
        rows.addStretch(0)  # takes the place of hidden topics
        self.show_model(None)

    def _row(self, text: str, name: str) -> QLabel:
        field = SelectableLabel(objectName=name)
        field.setWordWrap(True)
        field.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)  # never widens the panel
        self._form.addRow(text, field)
        return field

    @property
    def least_width(self) -> int:
        """The width of the buttons, which in a large font exceeds the panel's usual width."""
        return int(self._buttons.minimumSize().width())

    def show_model(self, model: Optional[Model]) -> None:
        self._empty.setVisible(model is None)
        self._content.setVisible(model is not None)
        if model is None:
            return
        self._name.show_line(escape(model.name))
        self._namespace.setText(f"/{model.namespace}" if model.namespace else "\u2013")
        self._file.setText(label(Path(model.file)) if model.file else "\u2013")
        self._file.setToolTip(model.file)
        failed = [f"{name} has failed" for name in model.failed]
        self._plugins.setText(", ".join([*model.plugins, *failed]) or "\u2013")
        self.topics.show_topics(_shown_topics(model), model.namespace)

    def heightForWidth(self, width: int) -> int:  # noqa: N802
        """The height below which a scroll area scrolls, with the list of topics at its minimum."""
        return int(self._content.layout().minimumHeightForWidth(width)) + _MARGIN

    def show_pose(self, pose: str, speed: str) -> None:
        self._pose.setText(pose)
        self._speed.setText(speed)


def _buttons(actions: ModelActions) -> QGridLayout:
    grid = QGridLayout()
    grid.setSpacing(4)
    for index, action in enumerate(actions.all):
        button = QToolButton()
        button.setDefaultAction(action)
        button.setToolButtonStyle(Qt.ToolButtonTextOnly)
        button.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Fixed)
        grid.addWidget(button, *divmod(index, _BUTTON_COLUMNS))
    return grid


def _shown_topics(model: Optional[Model]) -> List[Topic]:
    """The topics of a model in the panel, each once."""
    if model is None:
        return []
    by_name = {topic.name: topic for topic in sorted_topics(model.topics)}
    return list(by_name.values())


def _dot(color: Optional[str], ratio: float) -> QIcon:
    """A disc with a white edge, for contrast on a selected row; empty for None."""
    picture = QPixmap(round(_DOT * ratio), round(_DOT * ratio))
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.transparent)
    if color:
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.Antialiasing)
        painter.setPen(Qt.white)
        painter.setBrush(QColor(color))
        painter.drawEllipse(0, 0, _DOT - 1, _DOT - 1)
        painter.end()
    return QIcon(picture)
