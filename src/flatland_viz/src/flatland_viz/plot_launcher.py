"""Plots of topics from the panel: rqt_plot where it is installed, else the program `plot`."""

import shutil
import subprocess
import sys
from pathlib import Path
from typing import List

import rospkg
from python_qt_binding.QtCore import QPoint, Qt
from python_qt_binding.QtWidgets import QMenu, QTreeWidget, QTreeWidgetItem

HINT = "Double-click: plot"


def plot_command(topic: str) -> List[str]:
    """The command that plots a topic."""
    if shutil.which("rqt_plot"):
        return ["rqt_plot", topic]
    program = Path(rospkg.RosPack().get_path("flatland_viz"), "nodes", "plot")
    if not program.is_file():  # an installed package
        return ["rosrun", "flatland_viz", "plot", topic]
    return [sys.executable, str(program), topic]


def start_plot(topic: str) -> None:
    """Opens a plot of a topic, which goes on when this process ends."""
    subprocess.Popen(
        plot_command(topic), stdin=subprocess.DEVNULL, start_new_session=True, close_fds=True
    )


def offer_plots(tree: QTreeWidget) -> None:
    """Plots the topics of a tree by a double click, and by their menu.

    Args:
        tree: its first level has names of topics as `Qt.UserRole`.
    """

    def topic_of(item: QTreeWidgetItem) -> str:
        return str((item.parent() or item).data(0, Qt.UserRole))

    def show_menu(place: QPoint) -> None:
        item = tree.itemAt(place)
        if item is not None:
            menu = QMenu(tree, objectName="menu_topic")
            topic = topic_of(item)
            menu.addAction("&Plot").triggered.connect(lambda: start_plot(topic))
            menu.popup(tree.viewport().mapToGlobal(place))

    tree.setExpandsOnDoubleClick(False)
    tree.setContextMenuPolicy(Qt.CustomContextMenu)
    tree.customContextMenuRequested.connect(show_menu)
    tree.itemDoubleClicked.connect(lambda item, column: start_plot(topic_of(item)))
