"""Actions on the selected model: in the side panel, in its menu, by keys."""

import math
from typing import Any, Callable, Dict, Optional, Tuple

from python_qt_binding.QtCore import QObject, Signal
from python_qt_binding.QtGui import QCursor, QKeySequence
from python_qt_binding.QtWidgets import QAction, QApplication, QDialog, QMenu, QWidget

from flatland_viz.interaction import Interaction
from flatland_viz.model_list import Model, free_name, namespace_of_copy
from flatland_viz.move_dialog import MoveDialog
from flatland_viz.selection import Selection
from flatland_viz.server import Pose, Server
from flatland_viz.status import Simulation
from flatland_viz.topic_values import number

_GAP = 0.3  # m between a model and its duplicate


class ModelActions(QObject):
    """The actions, enabled as they apply.

    Args:
        window: the parent of dialogs and menus; the keys hold in it.
        server: carries out the actions.
        selection: the selected model.
        interaction: tool that selects and drags models.
        follow: makes the view follow a model by its name; the empty string ends that.
    """

    hint = Signal(str)
    """A message about a finished action."""
    followed = Signal(str)
    """The name of the model that the view follows now; empty if it follows none."""

    def __init__(
        self,
        window: QWidget,
        server: Server,
        selection: Selection,
        interaction: Interaction,
        follow: Callable[[str], None],
    ) -> None:
        super().__init__(window)
        self._window = window
        self._server = server
        self._selection = selection
        self._interaction = interaction
        self._follow_model = follow
        self._followed = ""
        self._models: Dict[str, Model] = {}
        self.has_edited = False
        """True if models have been changed in this window since they were saved."""
        self.follow = self._action("&Follow", "follow", self._toggle_follow, "F")
        self.follow.setCheckable(True)
        self.drive = self._action("&Drive", "drive", self._drive)
        self.copy_pose = self._action("&Copy pose", "copy_pose", self._copy_pose, "Ctrl+C")
        self.move_to = self._action("&Move to...", "move_to", self._ask_where, "M")
        self.duplicate = self._action("Dup&licate", "duplicate", self._duplicate, "Ctrl+D")
        self.delete = self._action("D&elete", "delete", self._delete, "Delete")
        self.undo = self._action("&Undo", "undo", lambda: server.undo(self._note_edit), "Ctrl+Z")
        self.redo = self._action(
            "&Redo", "redo", lambda: server.redo(self._note_edit), "Ctrl+Shift+Z"
        )
        for action in (self.undo, self.redo):
            action.setEnabled(False)  # until the server tells
        self._menu = QMenu(window, objectName="menu_model")
        self.fill(self._menu)
        selection.changed.connect(self._show)
        interaction.edited.connect(self._note_edit)
        interaction.menu_asked.connect(lambda name: self._menu.popup(QCursor.pos()))
        self._show()

    def _action(self, text: str, name: str, do: Callable[[], None], key: str = "") -> QAction:
        action = QAction(text, self._window, objectName=f"action_{name}")
        action.triggered.connect(lambda checked: do())
        action.setAutoRepeat(False)
        if key:
            action.setShortcut(QKeySequence(key))
            action.setToolTip(f"{text.replace('&', '').rstrip('.')} ({key})")
        self._window.addAction(action)
        return action

    @property
    def all(self) -> Tuple[QAction, ...]:
        """The actions that concern the selected model."""
        return (self.follow, self.drive, self.copy_pose, self.move_to, self.duplicate, self.delete)

    def fill(self, menu: QMenu) -> None:
        """Adds the actions to a menu."""
        menu.addActions([self.follow, self.drive])
        menu.addSeparator()
        menu.addActions([self.copy_pose, self.move_to, self.duplicate])
        menu.addSeparator()
        menu.addAction(self.delete)

    def set_models(self, models: Dict[str, Model]) -> None:
        """Sets the models in the world."""
        self._models = models
        if self._followed and self._followed not in models:
            self._set_followed("")
        self._show()

    def show_simulation(self, simulation: Simulation) -> None:
        """Shows the edits that can be undone and redone."""
        for action, word, text in (
            (self.undo, "&Undo", simulation.undo),
            (self.redo, "&Redo", simulation.redo),
        ):
            action.setEnabled(bool(text))
            action.setText(f"{word}: {text}" if text else word)

    @property
    def _model(self) -> Optional[Model]:
        return self._models.get(self._selection.name)

    @property
    def _pose(self) -> Optional[Pose]:
        """The pose of the selected model."""
        state = self._interaction.state
        return (state["x"], state["y"], state["theta"]) if state else None

    def _show(self, *_: Any) -> None:
        model = self._model
        for action in self.all:
            action.setEnabled(model is not None)
        self.drive.setEnabled(model is not None and bool(model.command_topic))
        self.duplicate.setEnabled(model is not None and bool(model.file))
        self.follow.setChecked(model is not None and self._followed == model.name)

    def _set_followed(self, name: str) -> None:
        self._followed = name
        self._follow_model(name)
        self.followed.emit(name)
        self._show()

    def _toggle_follow(self) -> None:
        name = self._selection.name
        self._set_followed("" if name == self._followed else name)

    def end_following(self) -> None:
        """Leaves the view where it is."""
        self._set_followed("")

    def _drive(self) -> None:
        self._selection.drive_asked.emit(self._selection.name)

    def _copy_pose(self) -> None:
        pose = self._pose
        if pose is not None:
            text = f"[{number(pose[0], 3)}, {number(pose[1], 3)}, {number(pose[2], 4)}]"
            QApplication.clipboard().setText(text)
            self.hint.emit(f"Copied {text}, as in a world file")

    def _ask_where(self) -> None:
        name, pose = self._selection.name, self._pose
        if pose is None:
            return
        dialog = MoveDialog(self._window, name, pose)
        if dialog.exec_() == QDialog.Accepted:
            self._server.move(name, dialog.pose, self._note_edit)

    def _note_edit(self) -> None:
        self.has_edited = True

    def _duplicate(self) -> None:
        model, pose = self._model, self._pose
        if model is None or pose is None:
            return
        name = free_name(model.name, self._models)
        namespace = namespace_of_copy(model, name, self._models.values())
        by = model.size + _GAP  # to the right of its heading
        x = pose[0] + by * math.sin(pose[2])
        y = pose[1] - by * math.cos(pose[2])

        own = f"~{namespace}" if namespace else ""  # with a frame of odometry of its own

        def spawned() -> None:
            self._selection.select(name)
            self._note_edit()

        self._server.spawn(model.file, name, own, (x, y, pose[2]), spawned)

    def _delete(self) -> None:
        name = self._selection.name
        if self._model is None:
            return

        def deleted() -> None:
            self.hint.emit(f"Deleted {name}.")
            self._note_edit()

        self._server.delete(name, deleted)
