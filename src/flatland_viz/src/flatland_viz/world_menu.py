"""The menu World: opens, reloads, resets and saves the world, and asks before changes are lost."""

from functools import partial
from pathlib import Path
from typing import Callable, List, Optional, Sequence

from python_qt_binding.QtWidgets import QMainWindow, QMenu, QMessageBox

from flatland_viz.actions import add_action
from flatland_viz.file_dialog import ask_for_file
from flatland_viz.model_actions import ModelActions
from flatland_viz.services import Services
from flatland_viz.settings import Settings
from flatland_viz.status import Simulation
from flatland_viz.world_files import copy_of, is_installed, title

_RECENT, _MOST_RECENT = "recent_worlds", 8
_KINDS = "Worlds (*.yaml *.yml)"


def names_of(paths: Sequence[str]) -> List[str]:
    """A name for each file: itself and its folder, since many are called world.yaml.

    The whole path, if that is the same for another file.
    """
    short = ["/".join(Path(path).parts[-2:]) for path in paths]
    return [path if short.count(name) > 1 else name for path, name in zip(map(str, paths), short)]


class WorldMenu(QMenu):
    """Acts on the world's file, and marks unsaved changes in the window's title.

    Args:
        window: window with the title to mark.
        services: services of the server, which reads and writes the file.
        actions: know whether models have been changed in this window, and not by programs alone.
        settings: settings, which keep the list of worlds.
    """

    def __init__(
        self, window: QMainWindow, services: Services, actions: ModelActions, settings: Settings
    ) -> None:
        super().__init__("&World", window)
        self.setToolTipsVisible(True)
        self._window = window
        self._services = services
        self._actions = actions
        self._settings = settings
        self._path = ""
        opens = add_action(self, "&Open...", self._ask_and_open, "Ctrl+O")
        self._recent = self.addMenu("Open &recent")
        self._recent.setToolTipsVisible(True)
        self._recent.aboutToShow.connect(self._fill_recent)
        reload = add_action(
            *(self, "Re&load files", services.reload, "F5"),
            "After an edit: loads the world's files again; time goes on",
        )
        self.reset = add_action(
            *(self, "Re&set", self._reset, "R"),
            "Start again: the world as it was loaded; time goes on",
        )
        self.addSeparator()
        self._save_action = add_action(
            *(self, "Sa&ve", self._save, "Ctrl+S"),
            "Moved, spawned and deleted models, into the world's file",
        )
        save_as = add_action(
            *(self, "Save &as...", self._save_as, "Ctrl+Shift+S"), "The same, into a new file"
        )
        self.addSeparator()
        self._with_server = (opens, self._recent, reload, self.reset, save_as)
        self.show_simulation(None)

    def set_world(self, path: str) -> None:
        """Sets the path of the world's file."""
        self._path = path
        self._window.setWindowTitle(title(path))
        others = [each for each in self._settings.list(_RECENT) if each != path]
        self._settings.set_list(_RECENT, [path, *others][:_MOST_RECENT])

    def show_simulation(self, simulation: Optional[Simulation]) -> None:
        """Enables the actions of use, and marks unsaved changes; None: there is no server.

        Models that programs alone have changed, such as robots that a launch file spawns, can be
        saved, but are no unsaved changes of the user's.
        """
        edits = simulation.edits if simulation is not None else 0
        for each in self._with_server:
            each.setEnabled(simulation is not None)
        self._save_action.setEnabled(edits > 0)
        is_modified = edits > 0 and self._actions.has_edited
        if is_modified != self._window.isWindowModified():  # else Qt would set the title again
            self._window.setWindowModified(is_modified)

    def keep_changes(self, what: str, then: Callable[[], object]) -> bool:
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

    def _ask_and_open(self) -> None:
        folder = str(Path(self._path).parent) if self._path else ""
        file = ask_for_file(self._window, "Open a World", folder, f"{_KINDS};;All files (*)")
        if file:
            self._open(file)

    def _open(self, path: str) -> None:
        then = partial(self._services.open, path)
        if not self.keep_changes("opening another world", then):
            then()

    def _reset(self) -> None:
        if not self.keep_changes("a reset", self._services.reset):
            self._services.reset()

    def _fill_recent(self) -> None:
        self._recent.clear()
        paths = [path for path in self._settings.list(_RECENT) if path != self._path]
        for path, name in zip(paths, names_of(paths)):
            add_action(self._recent, name.replace("&", "&&"), partial(self._open, path), tip=path)
        if not paths:
            self._recent.addAction("no other worlds yet").setEnabled(False)

    def _save(self, then: Callable[[], object] = lambda: None) -> None:
        """Saves in the world's file; in a copy if that is not the user's."""
        world = Path(self._path)
        if self._path and is_installed(world):
            self._ask_and_save("Save a Copy of the Installed World", copy_of(world), then)
        else:
            self._save_in("", then)

    def _save_as(self) -> None:
        world = Path(self._path)
        start = world if self._path and not is_installed(world) else copy_of(world)
        self._ask_and_save("Save the World", start, lambda: None)

    def _ask_and_save(self, title: str, start: Path, then: Callable[[], object]) -> None:
        file = ask_for_file(self._window, title, str(start), _KINDS, is_new=True)
        if file:
            self._save_in(file, then)

    def _save_in(self, path: str, then: Callable[[], object]) -> None:
        def saved() -> None:
            self._actions.has_edited = False
            then()

        self._services.save(path, saved)
