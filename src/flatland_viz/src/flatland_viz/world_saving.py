"""Saving the world, the mark of unsaved changes, and the question before they are lost."""

from pathlib import Path
from typing import Callable

from python_qt_binding.QtCore import QObject
from python_qt_binding.QtWidgets import QMainWindow, QMessageBox

from flatland_viz.file_dialog import ask_for_file
from flatland_viz.menus import Menus
from flatland_viz.server import Server


class WorldSaving(QObject):
    """Connects the menu's actions with the server, and marks the window's title.

    Args:
        window: its title has the place of the mark.
        server: writes the file.
        menus: have the actions.
        has_edited: whether models have been changed in this window, and not by programs alone.
    """

    def __init__(
        self, window: QMainWindow, server: Server, menus: Menus, has_edited: Callable[[], bool]
    ) -> None:
        super().__init__(window)
        self._window = window
        self._server = server
        self._menus = menus
        self._has_edited = has_edited
        self._world = ""
        menus.save_asked.connect(lambda: server.save(""))
        menus.save_as_asked.connect(self._save_as)
        self.show_edits(0)

    def set_world(self, path: str) -> None:
        """Sets the path of the world's file."""
        self._world = path

    def show_edits(self, count: int) -> None:
        """Shows how many models differ from the world's file."""
        if (count > 0) != self._window.isWindowModified():  # else Qt would set the title again
            self._window.setWindowModified(count > 0)
        self._menus.save.setEnabled(count > 0)

    def keep_changes(self, what: str, then: Callable[[], None]) -> bool:
        """Asks what to do with unsaved changes.

        Args:
            what: the action that loses them, such as "closing".
            then: the action; called after they are saved, or if they are to be dropped.

        Returns:
            True if there are unsaved changes of this window, and so a question; otherwise nothing
            is done.
        """
        if not (self._window.isWindowModified() and self._has_edited()):
            return False
        box = QMessageBox(
            QMessageBox.Question,
            "Flatland",
            "Save the changed models in the world's file?",
            QMessageBox.Save | QMessageBox.Discard | QMessageBox.Cancel,
            self._window,
        )
        box.setObjectName("unsaved")
        box.setInformativeText(f"Moved, spawned and deleted models are lost by {what}.")
        box.setDefaultButton(QMessageBox.Save)

        def answered(answer: int) -> None:
            if answer == QMessageBox.Save:
                self._server.save("", then)
            elif answer == QMessageBox.Discard:
                then()

        box.finished.connect(answered)
        box.open()
        return True

    def _save_as(self) -> None:
        start = str(Path(self._world) if self._world else Path.home() / "world.yaml")
        kinds = "Worlds (*.yaml *.yml)"
        file = ask_for_file(self._window, "Save the World", start, kinds, is_new=True)
        if file:
            self._server.save(file)
