"""The topics of a model in the panel: their rates and last values, and plots of them."""

import math
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Dict, List

import rospkg
from python_qt_binding.QtCore import QPoint, Qt
from python_qt_binding.QtWidgets import QFrame, QHeaderView, QMenu, QTreeWidget, QTreeWidgetItem

from flatland_viz.model_list import Topic
from flatland_viz.topic_monitor import Reading


class TopicTree(QTreeWidget):
    """Lists topics. A double click or their menu plots one."""

    def __init__(self) -> None:
        super().__init__(objectName="model_topics")
        self.setRootIsDecorated(False)
        self.setIndentation(10)
        self.setSelectionMode(QTreeWidget.NoSelection)
        self.setFocusPolicy(Qt.NoFocus)
        self.setFrameShape(QFrame.NoFrame)
        self.setHeaderLabels(["Topic", "Hz"])
        header = self.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.Stretch)
        header.setSectionResizeMode(1, QHeaderView.ResizeToContents)
        self.setExpandsOnDoubleClick(False)
        self.setContextMenuPolicy(Qt.CustomContextMenu)
        self.customContextMenuRequested.connect(self._show_menu)
        self.itemDoubleClicked.connect(lambda item, column: start_plot(_topic_of(item)))

    def show_topics(self, topics: List[Topic], namespace: str) -> None:
        """Lists topics by their names within a namespace; hidden without topics."""
        self.setVisible(bool(topics))
        self.clear()
        for topic in topics:
            item = QTreeWidgetItem([_short(topic.name, namespace), "..."])
            verb = "published" if topic.is_published else "subscribed"
            tip = (topic.name, topic.type, f"{verb} by {topic.plugin}", "Double-click: plot")
            item.setToolTip(0, "\n".join(tip))
            item.setData(0, Qt.UserRole, topic.name)
            item.setTextAlignment(1, Qt.AlignRight | Qt.AlignVCenter)
            self.addTopLevelItem(item)

    def show_readings(self, readings: Dict[str, Reading]) -> None:
        """Shows rates and last values, by the names of topics."""
        for index in range(self.topLevelItemCount()):
            item = self.topLevelItem(index)
            reading = readings.get(_topic_of(item))
            if reading is not None:
                item.setText(1, "..." if reading.rate is None else _rate(reading.rate))
                self._show_value(item, reading.value)

    def _show_value(self, item: QTreeWidgetItem, value: str) -> None:
        """Shows the last message of a topic in a line of its own."""
        if not item.childCount():
            if not value:
                return
            line = QTreeWidgetItem(item)
            item.setExpanded(True)
            line.setFirstColumnSpanned(True)
        item.child(0).setText(0, value)
        item.child(0).setToolTip(0, value)

    def _show_menu(self, place: QPoint) -> None:
        item = self.itemAt(place)
        if item is not None:
            menu = QMenu(self)
            topic = _topic_of(item)
            menu.addAction("&Plot").triggered.connect(lambda: start_plot(topic))
            menu.popup(self.viewport().mapToGlobal(place))


def start_plot(topic: str) -> None:
    """Opens a plot of a topic, which goes on when this process ends.

    By rqt_plot where it is installed, else by the program `plot`.
    """
    program = Path(rospkg.RosPack().get_path("flatland_viz"), "nodes", "plot")
    command = ["rosrun", "flatland_viz", "plot"]  # of an installed package
    if shutil.which("rqt_plot"):
        command = ["rqt_plot"]
    elif program.is_file():
        command = [sys.executable, str(program)]
    subprocess.Popen(
        [*command, topic], stdin=subprocess.DEVNULL, start_new_session=True, close_fds=True
    )


def _topic_of(item: QTreeWidgetItem) -> str:
    return str((item.parent() or item).data(0, Qt.UserRole))


def _short(topic: str, namespace: str) -> str:
    prefix = f"/{namespace}/"
    return topic[len(prefix) :] if namespace and topic.startswith(prefix) else topic


def _rate(rate: float) -> str:
    return f"{rate:.0f}" if rate >= 9.95 or math.isclose(rate, round(rate)) else f"{rate:.1f}"
