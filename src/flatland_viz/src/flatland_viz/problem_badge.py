"""The badge in the status line that counts problems, and the list that it opens."""

import time
from typing import List, Optional

from python_qt_binding.QtCore import Qt, Signal
from python_qt_binding.QtGui import QColor, QPalette
from python_qt_binding.QtWidgets import (
    QApplication,
    QDialog,
    QDialogButtonBox,
    QHeaderView,
    QPlainTextEdit,
    QStatusBar,
    QToolButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from flatland_viz.problem_sources import ProblemSources
from flatland_viz.problems import Problem, Problems, summary
from flatland_viz.window_size import on_screen

_STYLE = (
    "QToolButton {{ background: {}; color: {}; border: 0; border-radius: 3px; padding: 1px 8px }}"
)
_WARNING = _STYLE.format("#f0c419", "black")
_ERROR = _STYLE.format("#c62828", "white")
_RED = {"light": QColor("#c62828"), "dark": QColor("#ff8075")}
_COLUMNS = ("Time", "Count", "From", "Problem")
_REAL_TIME = 1e9
"""Later times are not simulated ones: it was reached in 2001 [s]."""


class ProblemBadge(QToolButton):
    """Says how many problems there are; hidden if there are none. A click lists them.

    Args:
        line: status line that shows the badge.
        sources: report the problems.
    """

    def __init__(self, line: QStatusBar, sources: ProblemSources) -> None:
        super().__init__()
        self.setObjectName("problems")
        self.setToolTip("What the server, /diagnostics and transforms warn of. Click to read it.")
        self._problems = Problems()
        self._list: Optional[ProblemList] = None
        line.insertPermanentWidget(2, self)  # behind the hint and the notice of transforms
        self.clicked.connect(self._open)
        sources.reported.connect(self._report)
        self._show_count()

    def _report(self, group: str, problems: List[Problem]) -> None:
        before = self._problems.latest_first
        self._problems.report(group, problems)
        if self._problems.latest_first != before:
            self._show_count()

    def clear(self) -> None:
        """Forgets all problems."""
        self._problems.clear()
        self._show_count()

    def _show_count(self) -> None:
        problems = self._problems.latest_first
        self.setVisible(bool(problems))
        self.setText(f"{len(problems)} problem{'s' if len(problems) != 1 else ''}")
        self.setStyleSheet(_ERROR if self._problems.has_errors else _WARNING)
        if self._list is not None:
            self._list.show_problems(problems)

    def _open(self) -> None:
        if self._list is None:
            self._list = ProblemList(self.window())
            self._list.clear_asked.connect(self.clear)
            self._list.show_problems(self._problems.latest_first)
        self._list.show()
        self._list.raise_()
        self._list.activateWindow()


def _shown(seconds: float) -> str:
    """A stamp: simulated time, or the time of day if stamps are of real time; empty without one."""
    if seconds > _REAL_TIME:
        return time.strftime("%H:%M:%S", time.localtime(seconds))
    return f"{seconds:.1f} s" if seconds else ""


class ProblemList(QDialog):
    """A list of problems, the latest first."""

    clear_asked = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("problem_list")
        self.setWindowTitle("Problems")
        self._tree = QTreeWidget(objectName="problem_tree")
        self._tree.setHeaderLabels(_COLUMNS)
        self._tree.setRootIsDecorated(False)
        self._tree.setAlternatingRowColors(True)
        self._tree.setVerticalScrollMode(QTreeWidget.ScrollPerPixel)
        self._tree.setSelectionMode(QTreeWidget.ExtendedSelection)
        self._tree.currentItemChanged.connect(self._show_text)
        self._tree.header().setSectionResizeMode(QHeaderView.ResizeToContents)
        self._tree.header().setSectionResizeMode(len(_COLUMNS) - 1, QHeaderView.Stretch)
        self._text = QPlainTextEdit(objectName="problem_text", readOnly=True)
        self._text.setMaximumHeight(6 * self.fontMetrics().lineSpacing())
        buttons = QDialogButtonBox(QDialogButtonBox.Close)
        buttons.rejected.connect(self.close)
        clear = buttons.addButton("C&lear", QDialogButtonBox.ResetRole)
        clear.clicked.connect(self.clear_asked)
        copy = buttons.addButton("&Copy", QDialogButtonBox.ActionRole)
        copy.clicked.connect(self._copy)
        layout = QVBoxLayout(self)
        layout.addWidget(self._tree)
        layout.addWidget(self._text)
        layout.addWidget(buttons)
        self.resize(on_screen(760, 320))

    def show_problems(self, problems: List[Problem]) -> None:
        """Fills the list; the latest is selected."""
        self._tree.clear()
        is_dark = self.palette().color(QPalette.Base).lightness() < 128
        for problem in problems:
            row = (_shown(problem.time), str(problem.times), problem.source, summary(problem.text))
            item = QTreeWidgetItem(self._tree, row)
            item.setData(0, Qt.UserRole, problem.text)
            for column in (0, 1):
                item.setTextAlignment(column, Qt.AlignRight | Qt.AlignTop)
            item.setTextAlignment(2, Qt.AlignTop)
            if problem.is_error:
                item.setForeground(len(row) - 1, _RED["dark" if is_dark else "light"])
        if problems:
            self._tree.setCurrentItem(self._tree.topLevelItem(0))

    def _show_text(self, item: Optional[QTreeWidgetItem]) -> None:
        self._text.setPlainText(item.data(0, Qt.UserRole) if item else "")

    def _copy(self) -> None:
        items = self._tree.selectedItems() or [
            self._tree.topLevelItem(index) for index in range(self._tree.topLevelItemCount())
        ]
        lines = ["\t".join(item.text(i) for i in range(len(_COLUMNS))) for item in items]
        QApplication.clipboard().setText("\n".join(lines))
