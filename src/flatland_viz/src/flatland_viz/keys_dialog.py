"""One page with the window's keys and mouse actions."""

from html import escape
from typing import Iterable, List, Sequence, Tuple

from python_qt_binding.QtCore import Qt
from python_qt_binding.QtGui import QKeySequence
from python_qt_binding.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QMenu,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from flatland_teleop.driving_keys import HELP
from flatland_viz.window_size import on_screen

Rows = List[Tuple[str, str]]
"""Keys and their actions."""

MOUSE: Rows = [
    ("click on a model", "selects it; drag it by its middle, turn it by its ring"),
    ("right button on a model", "its menu"),
    ("drag elsewhere", "moves the map; with Ctrl, turns it"),
    ("wheel", "zooms at the cursor"),
]
DRIVING: Rows = list(HELP)


def rows_of(menu: QMenu) -> Rows:
    """The actions of a menu and its submenus that have a key."""
    rows: Rows = []
    for action in menu.actions():
        if action.menu() is not None:
            rows += rows_of(action.menu())
            continue
        key = action.shortcut().toString(QKeySequence.NativeText)
        if key:
            rows.append((key, action.text().replace("&", "").rstrip(".")))
    return rows


def page(columns: Sequence[Sequence[Tuple[str, Rows]]]) -> str:
    """Columns of titled tables as rich text; a table without rows is left out."""
    cells = ("".join(_table(*each) for each in column if each[1]) for column in columns)
    return f"<table><tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr></table>"


def _table(title: str, rows: Iterable[Tuple[str, str]]) -> str:
    lines = "".join(
        f"<tr><td style='padding: 2px 14px 2px 0'><b>{escape(key).replace(' ', '&nbsp;')}</b></td>"
        f"<td style='padding: 2px 24px 2px 0'>{escape(text)}</td></tr>"
        for key, text in rows
    )
    return f"<h4>{escape(title)}</h4><table cellspacing='0'>{lines}</table>"


class KeysDialog(QDialog):
    """Shows the page; the window can be used meanwhile.

    Args:
        parent: the window.
        columns: of titled tables.
    """

    def __init__(self, parent: QWidget, columns: Sequence[Sequence[Tuple[str, Rows]]]) -> None:
        super().__init__(parent)
        self.setObjectName("keys_dialog")
        self.setWindowTitle("Keys and Mouse")
        self.setAttribute(Qt.WA_DeleteOnClose)
        text = QTextBrowser()
        text.setLineWrapMode(QTextBrowser.NoWrap)
        text.setHtml(page(columns))
        buttons = QDialogButtonBox(QDialogButtonBox.Close)
        buttons.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addWidget(text)
        layout.addWidget(buttons)
        self.resize(on_screen(860, 640))
