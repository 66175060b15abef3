"""The services of the server, called without blocking the window.

Each call runs on a thread of its own. The signals are delivered by Qt on the window's thread.
"""

import threading
from typing import Any, Callable, Optional, Tuple, Union

import rospy
from flatland_msgs.srv import (
    ChangeRate,
    DeleteModel,
    MoveModel,
    OpenWorld,
    Reset,
    SaveWorld,
    Seek,
    SpawnModel,
    Step,
)
from geometry_msgs.msg import Pose2D
from python_qt_binding.QtCore import QObject, Signal
from std_srvs.srv import Empty, Trigger

from flatland_viz.error_text import error_text

Pose = Tuple[float, float, float]
"""x, y [m] and yaw [rad]."""

Then = Callable[[], object]
"""Called on the window's thread after success."""


class Services(QObject):
    """Calls the services, until `close`."""

    failed = Signal(str)
    """The error of a call."""
    refused = Signal(str, str)
    """A refused change of world: a title, and the reason, which may have many lines."""
    done = Signal(str)
    """A message about a successful call."""
    renewed = Signal()
    """The world was reset or loaded by this window."""
    _succeeded = Signal(object)
    """A function to call on the window's thread."""

    def __init__(self) -> None:
        super().__init__()
        self._succeeded.connect(lambda then: then())

    def close(self) -> None:
        """No signal is emitted after this."""
        self.blockSignals(True)

    def toggle_pause(self) -> None:
        """Stops simulated time, or resumes it."""
        self._call("toggle_pause", Empty)

    def change_rate(self, rate: float) -> None:
        """Sets how many seconds are simulated per second of real time; may be infinite."""
        self._call("change_rate", ChangeRate, rate)

    def spawn(self, file: str, name: str, namespace: str, pose: Pose, then: Then) -> None:
        """Spawns a model of a file."""
        self._call("spawn_model", SpawnModel, file, name, namespace, Pose2D(*pose), then=then)

    def delete(self, name: str, then: Then) -> None:
        """Deletes a model."""
        self._call("delete_model", DeleteModel, name, then=then, done=f"Deleted {name}.")

    def move(self, name: str, pose: Pose, then: Then) -> None:
        """Moves a model."""
        self._call("move_model", MoveModel, name, Pose2D(*pose), then=then)

    def undo(self, then: Then) -> None:
        """Undoes the latest edit of any client."""
        self._call("undo", Trigger, then=then, done=lambda response: response.message)

    def redo(self, then: Then) -> None:
        """Does again what was undone last."""
        self._call("redo", Trigger, then=then, done=lambda response: response.message)

    def step(self, count: int) -> None:
        """Makes steps while the simulation is paused."""
        steps = "1 step" if count == 1 else f"{count} steps"
        self._call(
            *("step", Step, count, [], 0.0),
            done=lambda response: f"{steps}, to {response.time.to_sec():.3f} s",
        )

    def seek(self, time: float) -> None:
        """Pauses, and goes to a time of the run [s]."""
        self._call("seek", Seek, time)

    def reset(self) -> None:
        """Resets the world to the state in which it was loaded."""
        self._call(
            *("reset", Reset, False, False, 0),
            then=self.renewed.emit,
            done="The world is as it was loaded.",
            refused="The world is not reset",
        )

    def reload(self) -> None:
        """Loads the world again from its files."""
        self._call(
            *("reload_world", Trigger),
            then=self.renewed.emit,
            done="The world's files are loaded.",
            refused="The files are not loaded",
        )

    def open(self, path: str) -> None:
        """Opens another world in place of this one."""
        self._call(
            *("open_world", OpenWorld, path),
            then=self.renewed.emit,
            done=f"Opened {path}",
            refused=f"{path} is not opened",
        )

    def save(self, path: str, then: Then) -> None:
        """Saves moved, spawned and deleted models in the world's file, or in a copy of it.

        Args:
            path: of the copy; empty for the world's own file.
            then: called after success.
        """
        done = f"Saved {path}" if path else "The world's file is saved."
        refused = "The world is not saved"
        self._call("save_world", SaveWorld, path, then=then, done=done, refused=refused)

    def _call(
        self,
        name: str,
        service: Any,
        *arguments: Any,
        then: Optional[Then] = None,
        done: Union[str, Callable[[Any], str]] = "",
        refused: str = "",
    ) -> None:
        """Calls a service; emits `failed` if that does not succeed.

        Args:
            name: name of the service, such as "pause".
            service: class of the service.
            arguments: the request's arguments.
            then: called on the window's thread after success.
            done: a message for `done` on success, or a function that makes it of the response.
            refused: the title for `refused`, which is then emitted instead of `failed`.
        """

        def fail(error: str) -> None:
            if refused:
                self.refused.emit(refused, error)
            else:
                self.failed.emit(f"{name}: {error}")

        def call() -> None:
            try:
                response = rospy.ServiceProxy(name, service)(*arguments)
            except (rospy.ServiceException, rospy.ROSException) as error:
                fail(str(error))
                return
            if not getattr(response, "success", True):
                fail(error_text(response.message))
                return
            if then is not None:
                self._succeeded.emit(then)
            if done:
                self.done.emit(done(response) if callable(done) else done)

        threading.Thread(target=call, name=name, daemon=True).start()
