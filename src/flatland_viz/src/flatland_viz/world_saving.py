"""Saving the world, the mark of unsaved changes, and the question before they are lost."""

from pathlib import Path
from typing import Callable

from python_qt_binding.QtCore import QObject
from python_qt_binding.QtWidgets import QMainWindow, QMessageBox

from flatland_viz.file_dialog import ask_for_file
from flatland_viz.menus import Menus
from flatland_viz.model_workbench import ModelWorkbench
from flatland_viz.server import Server
from flatland_viz.world_files import copy_of, is_installed


class WorldSaving(QObject):
    """Connects the menu's actions with the server, and marks the window's title.

    Args:
        window: window with the title to mark.
        server: server that writes the file.
        menus: menus with the actions.
        workbench: knows whether models have been changed in this window, and not by programs alone.
    """

    def __init__(
        self, window: QMainWindow, server: Server, menus: Menus, workbench: ModelWorkbench
    ) -> None:
        super().__init__(window)
        self._window = window
        self._server = server
        self._menus = menus
        self._workbench = workbench
        self._world = ""
        menus.save_asked.connect(self._save)
        menus.save_as_asked.connect(self._save_as)
        self.show_edits(0)

    def set_world(self, path: str) -> None:
        """Sets the path of the world's file."""
        self._world = path

    def show_edits(self, count: int) -> None:
        """Shows how many models differ from the world's file.

        Those that programs alone have changed, such as robots that a launch file spawns, can be
        saved, but are no unsaved changes of the user's.
        """
        is_modified = count > 0 and self._workbench.has_edited
        if is_modified != self._window.isWindowModified():  # else Qt would set the title again
            self._window.setWindowModified(is_modified)
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
        if not self._window.isWindowModified():
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
                self._save(then)
            elif answer == QMessageBox.Discard:
                then()

        box.finished.connect(answered)
        box.open()
        return True

    def _save(self, then: Callable[[], None] = lambda: None) -> None:
        """Saves in the world's file; in a copy if that is not the user's."""
        world = Path(self._world)
        if self._world and is_installed(world):
            self._ask_and_save("Save a Copy of the Installed World", copy_of(world), then)
        else:
            self._save_in("", then)

    def _save_as(self) -> None:
        world = Path(self._world)
        start = world if self._world and not is_installed(world) else copy_of(world)
        self._ask_and_save("Save the World", start, lambda: None)

    def _ask_and_save(self, title: str, start: Path, then: Callable[[], None]) -> None:
        kinds = "Worlds (*.yaml *.yml)"
        file = ask_for_file(self._window, title, str(start), kinds, is_new=True)
        if file:
            self._save_in(file, then)

    def _save_in(self, path: str, then: Callable[[], None]) -> None:
        def saved() -> None:
            self._workbench.note_saved()
            then()

        self._server.save(path, saved)
