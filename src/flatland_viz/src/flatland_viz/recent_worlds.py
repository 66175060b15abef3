"""The worlds that were opened last, and their menu."""

from functools import partial
from pathlib import Path
from typing import List, Sequence

from python_qt_binding.QtCore import Signal
from python_qt_binding.QtWidgets import QMenu

from flatland_viz.settings import Settings

_LIMIT = 8
_KEY = "recent_worlds"


def with_recent(recent: Sequence[str], path: str) -> List[str]:
    """The list of recent files with `path` moved or added to the front."""
    return [path, *(each for each in recent if each != path)][:_LIMIT]


def names_of(paths: Sequence[str]) -> List[str]:
    """A name for each file: itself and its folder, since many are called world.yaml.

    The whole path, if that is the same for another file.
    """
    short = ["/".join(Path(path).parts[-2:]) for path in paths]
    return [path if short.count(name) > 1 else name for path, name in zip(map(str, paths), short)]


class RecentMenu(QMenu):
    """Lists the worlds that were opened last, but for the present one.

    Args:
        settings: settings, which keep the list.
    """

    chosen = Signal(str)
    """The path of a world's file."""

    def __init__(self, settings: Settings) -> None:
        super().__init__("Open &recent", objectName="menu_recent")
        self.setToolTipsVisible(True)
        self._settings = settings
        self._present = ""
        self.aboutToShow.connect(self._fill)

    def add(self, path: str) -> None:
        """Puts the world that is open now at the beginning of the list."""
        self._present = path
        self._settings.set_list(_KEY, with_recent(self._settings.list(_KEY), path))

    def _fill(self) -> None:
        self.clear()
        paths = [path for path in self._settings.list(_KEY) if path != self._present]
        for path, name in zip(paths, names_of(paths)):
            action = self.addAction(name.replace("&", "&&"), partial(self.chosen.emit, path))
            action.setToolTip(path)
        if not paths:
            self.addAction("no other worlds yet").setEnabled(False)
