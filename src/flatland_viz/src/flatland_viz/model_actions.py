"""Actions on the selected model: in its menu, by keys, and by buttons of the side panel."""

import math
import re
from typing import Callable, Dict, Optional, Tuple

from python_qt_binding.QtCore import QObject, Signal
from python_qt_binding.QtGui import QCursor
from python_qt_binding.QtWidgets import QAction, QApplication, QInputDialog, QMenu, QWidget

from flatland_viz.actions import add_action
from flatland_viz.model_list import Model, free_name, namespace_of_copy
from flatland_viz.selection import Selection
from flatland_viz.services import Pose, Services
from flatland_viz.status import Simulation
from flatland_viz.topic_values import number

_GAP = 0.3  # m between a model and its duplicate


class ModelActions(QObject):
    """The actions, enabled as they apply.

    Args:
        window: the parent of dialogs and menus; the keys hold in it.
        services: carry out the actions.
        selection: the selected model.
        follow: makes the view follow a model by its name; the empty string ends that.
    """

    hint = Signal(str)
    """A message about a finished action."""
    followed = Signal(str)
    """The name of the model that the view follows now; empty if it follows none."""

    def __init__(
        self,
        window: QWidget,
        services: Services,
        selection: Selection,
        follow: Callable[[str], None],
    ) -> None:
        super().__init__(window)
        self._window = window
        self._services = services
        self._selection = selection
        self._follow_model = follow
        self._followed = ""
        self._models: Dict[str, Model] = {}
        self.has_edited = False
        """True if models have been changed in this window since they were saved."""
        self.follow = add_action(window, "&Follow", self._toggle_follow, "F")
        self.follow.setCheckable(True)
        self.drive = add_action(window, "&Drive", self._drive)
        self.copy_pose = add_action(window, "&Copy pose", self._copy_pose, "Ctrl+C")
        self.move_to = add_action(window, "&Move to...", self._ask_where, "Ctrl+M")
        self.duplicate = add_action(window, "Dup&licate", self._duplicate, "Ctrl+D")
        self.delete = add_action(window, "D&elete", self._delete, "Delete")
        self.undo = add_action(window, "&Undo", lambda: services.undo(self._note_edit), "Ctrl+Z")
        self.redo = add_action(
            window, "&Redo", lambda: services.redo(self._note_edit), "Ctrl+Shift+Z"
        )
        for action in (self.undo, self.redo):
            action.setEnabled(False)  # until the server tells
        self._menu = QMenu(window)
        self.fill(self._menu)
        selection.changed.connect(lambda name: self._show())
        selection.edited.connect(self._note_edit)
        selection.menu_asked.connect(lambda: self._menu.popup(QCursor.pos()))
        self._show()

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
        state = self._selection.state
        return (state["x"], state["y"], state["theta"]) if state else None

    def _show(self) -> None:
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
            QApplication.clipboard().setText(text_of(pose))
            self.hint.emit(f"Copied {text_of(pose)}, as in a world file")

    def _ask_where(self) -> None:
        name, pose = self._selection.name, self._pose
        if pose is None:
            return
        text, is_given = QInputDialog.getText(
            *(self._window, f"Move {name}", "x [m], y [m], yaw [rad], as in a world file:"),
            text=text_of(pose),
        )
        if is_given:
            wanted = pose_in(text)
            if wanted is None:
                self.hint.emit(f"{text} is no pose")
            else:
                self._services.move(name, wanted, self._note_edit)

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

        self._services.spawn(model.file, name, own, (x, y, pose[2]), spawned)

    def _delete(self) -> None:
        name = self._selection.name
        if self._model is None:
            return

        self._services.delete(name, self._note_edit)


def text_of(pose: Pose) -> str:
    """A pose as in a world file."""
    return f"[{number(pose[0], 3)}, {number(pose[1], 3)}, {number(pose[2], 4)}]"


def pose_in(text: str) -> Optional[Pose]:
    """The pose that is written in a text, in brackets or not; None if it has not three numbers."""
    try:
        x, y, yaw = (float(part) for part in re.split(r"[\s,]+", text.strip("[] \t")))
    except ValueError:
        return None
    return (x, y, yaw) if all(map(math.isfinite, (x, y, yaw))) else None
