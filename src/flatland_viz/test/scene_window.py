"""The window with several robots in the test room, without a localiser."""

import numpy as np
from screen_pictures import near
from window_map import RoomMap

BOX = (194, 145, 87)
CRATE = (1.5, 1.5)


class SceneWindow:
    """The window with the test room and its robots.

    Args:
        screen: the X display that shows it.
        ros: the master, with a server.
        waiting: `wait_until`.
        id: the window's X id.

    Attributes:
        view: rows and columns of the view on the screen.
        map: of the room in it.
    """

    def __init__(self, screen, ros, waiting, id):
        self.screen, self.ros, self.waiting, self.id = screen, ros, waiting, id
        self.show_all()

    def show_all(self):
        """Shows the whole room, by the key; returns its map once it is steady."""
        self.screen.focus(self.id)
        self.screen.key("Home")
        seen = []

        def is_steady():
            try:
                pixels = self.picture("scene")
                self.view = self.screen.view(pixels)
                seen.append(RoomMap(pixels, self.screen.kind.walls, *self.view))
            except LookupError:
                seen.clear()
            return len(seen) > 1 and seen[-1].pixel(0, 0) == seen[-2].pixel(0, 0)

        self.waiting(is_steady, "the whole room", 30)
        self.map = seen[-1]
        return self.map

    def picture(self, name):
        return self.screen.picture(f"scene_{name}")

    def inside(self, pixels):
        """The pixels of the room's floor, away from the walls."""
        left, top = self.map.pixel(-4.7, 2.7)
        right, bottom = self.map.pixel(4.7, -2.7)
        return pixels[top:bottom, left:right]

    def drag(self, begin, end, *keys):
        """Drags with the left button between two pixels, while keys are held."""
        for key in keys:
            self.screen.xdotool("keydown", key)
        self.screen.drag(np.linspace(begin, end, 8))
        for key in keys:
            self.screen.xdotool("keyup", key)

    def transforms(self):
        """The parents of the frames in half a second's messages on /tf."""
        found = {}
        for message in self.ros.messages("/tf", "tf2_msgs/TFMessage", 0.5):
            for transform in message["transforms"]:
                found[transform["child_frame_id"]] = transform["header"]["frame_id"]
        return found

    def subscriptions(self):
        """The topics to which the window's Python part subscribes."""
        subscribers = self.ros.master.ask("getSystemState")[1]
        return {topic for topic, nodes in subscribers if "/flatland_viz" in nodes}

    def click(self, x, y):
        """Clicks at a point of the world [m]."""
        self.screen.focus(self.id)
        self.screen.click(self.map.pixel(x, y))

    def open_menu(self, x, y):
        """Opens the menu of the object at a point of the world [m]."""
        self.screen.focus(self.id)
        self.screen.open_menu(self.map.pixel(x, y), "menu")

    def place_of_crate(self, name):
        """The middle of the crate on the screen."""
        rows, columns = self.view
        ys, xs = np.nonzero(near(self.picture(name)[rows, columns], BOX, 25))
        if len(xs) <= 100:
            return None
        return columns.start + xs.mean() + 0.5, rows.start + ys.mean() + 0.5
