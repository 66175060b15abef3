"""The window with a world of one robot in the test room, opened by scripts/run."""

from contextlib import contextmanager
from pathlib import Path

import numpy as np
from screen_pictures import near
from window_map import RoomMap

STATES = {"paused": (0, 114, 178), "no server": (198, 40, 40)}
BADGE = {"warning": (240, 196, 25), "error": (198, 40, 40)}
WORLDS = Path(__file__).resolve().parents[2] / "flatland_server" / "worlds"
ROBOT = WORLDS / "office" / "turtlebot.model.yaml"
WORLD = f"""properties: {{}}
layers:
  - {{name: room, map: {WORLDS}/test_room/room.yaml, color: [0.4, 0.4, 0.4, 1]}}
models:
  - {{name: turtlebot, pose: [0, 0, 0], model: {ROBOT}}}
"""
_LINE = 27  # Qt's pixels: height of the status line


class RoomWindow:
    """The window with a world of one robot, which can be edited.

    Args:
        screen: the X display that shows it.
        ros: the master that the launch joins.
        waiting: `wait_until`.
        run: starts scripts/run.
        folder: for the world's file.
    """

    def __init__(self, screen, ros, waiting, run, folder):
        self.screen, self.ros, self.waiting = screen, ros, waiting
        self.world = folder / "room" / "world.yaml"
        self.world.parent.mkdir()
        self.world.write_text(WORLD)
        self.launch = ros.launch(run, str(self.world))
        self.id = screen.wait_for_window("Flatland - room/world.yaml")
        self.map = waiting(self._find_map, "the room")

    def _find_map(self):
        pixels = self.screen.picture("window_first")
        rows, columns = self.screen.view(pixels)
        try:
            return RoomMap(pixels, self.screen.kind.walls, rows, columns)
        except LookupError:
            return None

    def key(self, *keys):
        """Presses keys in the window, not in one of its dialogs."""
        self.screen.focus(self.id)
        self.screen.key(*keys)

    def press(self, key):
        """Presses the key of one of rviz's tools, with the mouse over the view."""
        self.screen.focus(self.id)
        self.screen.move(self.map.pixel(1.4, 1.5))
        self.screen.move(self.map.pixel(1.5, 1.5))
        self.screen.key(key)

    def choose_model(self, file, name=""):
        """Chooses a model to spawn in the palette: by its file, with a name of its own if given."""
        self.press("a")
        self.screen.wait_for_dialog("Spawn Model")
        self.screen.key("alt+f", "ctrl+a")
        self.screen.type(file)
        if name:
            self.screen.key("alt+n", "ctrl+a")
            self.screen.type(name)
        self.screen.close("Spawn Model", "Return")

    def wait_for_state(self, **values):
        def holds():
            state = self.ros.state()
            return all(state[name] == value for name, value in values.items())

        self.waiting(holds, str(values))

    def status_line(self, name):
        """A screenshot of the status line, and its left and top position."""
        left, _, right, bottom = self.screen.inside(self.id)
        top = bottom - self.screen.px(_LINE)
        return self.screen.picture(name)[top:bottom, left:right], (left, top)

    def says(self, state):
        """True if the status line shows a state of the simulation, by its background."""
        line, _ = self.status_line("window_status")
        return near(line, STATES[state], 5).sum() > 200

    def badge(self, kind):
        """The middle of the status line's badge of this colour; None if there is none."""
        line, (left, top) = self.status_line("window_badge")
        ys, xs = near(line, BADGE[kind], 5).nonzero()
        return (left + xs.mean(), top + ys.mean()) if len(xs) > 300 else None

    def has_hint(self):
        """True if the status line shows a hint or message, at its left end."""
        line, _ = self.status_line("window_hint")
        left = line[:, self.screen.px(2) : self.screen.px(80)].astype(int)
        return (abs(left - np.median(left)).max(axis=2) > 80).sum() > 40

    def is_driving_panel_open(self):
        """True if the Drive panel has opened the robot's topic."""
        return "/flatland_viz" in dict(self.ros.master.ask("getSystemState")[0]).get("/cmd_vel", ())

    @contextmanager
    def held(self, key):
        """Holds a key down in its context."""
        self.screen.focus(self.id)
        self.screen.xdotool("keydown", key)
        try:
            yield
        finally:
            self.screen.xdotool("keyup", key)

    def command(self):
        """The present command: speed [m/s] and turn [rad/s]."""
        twist = self.ros.message("/cmd_vel", "geometry_msgs/Twist")
        return twist["linear"]["x"], twist["angular"]["z"]

    def wait_for_rest(self):
        def rests():
            odometry = self.ros.message("/odometry/ground_truth", "nav_msgs/Odometry")
            twist = odometry["twist"]["twist"]
            return abs(twist["linear"]["x"]) + abs(twist["angular"]["z"]) < 1e-3

        self.waiting(rests, "the robot to stop")

    def wait_for_models(self, *names):
        self.waiting(lambda: self.ros.models() == [*names], f"the models {names}")

    def published_models(self, *names):
        """The models of the server's topic, once it has these: it follows the services."""

        def published():
            message = self.ros.message("/flatland_server/models", "flatland_msgs/ModelList")
            models = message["models"]
            return models if [each["name"] for each in models] == [*names] else None

        return self.waiting(published, f"the models {names} in the topic")

    def open_problems(self, kind, name):
        """Opens the list by a click on the badge."""
        self.screen.click(self.waiting(lambda: self.badge(kind), "the badge", 30))
        dialog = self.screen.wait_for_dialog("Problems")
        self.waiting(lambda: self.is_drawn(dialog, name), "the list")

    def is_drawn(self, dialog, name):
        """True if a dialog with a list is drawn."""
        return near(self.screen.picture_of(dialog, name), self.screen.kind.paper, 3).mean() > 0.3
