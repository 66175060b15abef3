"""The content of the window and the actions of its keys, independent of a window."""

import math
import time
from pathlib import Path
from typing import Callable, List, Optional, Tuple

from PIL import Image

from flatland2d.rendering.image_canvas import ImageCanvas
from flatland2d.rendering.renderer import Renderer
from flatland2d.rendering.view import Size, View
from flatland2d.simulation import Simulation
from flatland2d.viewer.keyboard_drive import KeyboardDrive, first_drive
from flatland2d.viewer.playback import Playback
from flatland2d.viewer.timeline import Timeline
from flatland2d.viewer.trail import Trail
from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Point

_FOLLOW_WIDTH = 12.0  # m
_RING = (0.45, 0.45, 0.87, 0.9)
_RING_WIDTH = 2.0  # px
_RING_GAP = 5.0  # px
_REACH = 8.0  # px; how far a click may be off a model
_ZOOM = 1.2
_STEP_TIME = 0.025  # s of real time for steps in each frame


class Viewer:
    """A simulation, a view of it, and the model that is chosen.

    Args:
        simulation: is shown and stepped.
        size: of the picture [px].
        rate: simulated seconds per second of real time.
        follow: the model that is chosen and followed; by default the first one with a drive is
            chosen, and the whole world shown.
        history: whether states are kept, to go back in time.
        clock: returns the real time [s].

    Raises:
        FlatlandError: there is no such model, or the size is not usable.
    """

    def __init__(
        self,
        simulation: Simulation,
        size: Size,
        *,
        rate: float = 1.0,
        follow: Optional[str] = None,
        history: bool = True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.simulation = simulation
        self.playback = Playback(rate)
        self.timeline = Timeline(simulation, history)
        self.drive = KeyboardDrive(simulation)
        self.chosen = ""
        """The name of the model that is driven and followed; empty if there is none."""
        self.is_following = False
        self.shows_sensors = True
        self.shows_names = False
        self.shows_trail = False
        self.shows_help = False
        self.message = ""
        """A message to the user about the last event."""
        self._clock = clock
        self._renderer = Renderer(simulation.world, simulation.timekeeper)
        self._trail = Trail(simulation)
        self.view = self._renderer.view(size)
        self.choose(next(iter(self._robots()), ""))
        if follow is not None:
            self.choose(simulation.models[follow].name)
            self.follow()

    # Time

    def advance(self, elapsed: float) -> None:
        """Makes the steps that are due after some real time [s]."""
        end = self._clock() + _STEP_TIME
        self.playback.advance(
            elapsed, self.simulation.step_size, self._step, lambda: self._clock() >= end
        )

    def toggle_pause(self) -> None:
        """Pauses or goes on; from a moment of the past, another run begins."""
        self.playback.is_paused = not self.playback.is_paused
        if not self.playback.is_paused and self.timeline.is_in_past:
            self.message = f"goes on from {self.simulation.time:.2f} s"

    def single_step(self) -> None:
        """Pauses, and makes one step; in the past, to the next moment of the run."""
        self.playback.is_paused = True
        if self.timeline.is_in_past:
            self.seek(self.simulation.time + self.simulation.step_size)
        else:
            self._step()

    def seek(self, time: float) -> None:
        """Pauses, and shows the moment at a time [s], or the first or last one."""
        self.playback.is_paused = True
        try:
            self.timeline.seek(time)
        except FlatlandError as error:
            self.message = self.timeline.problem or str(error)
        self.drive.time_has_jumped()
        self._trail.clear()

    def seek_by(self, seconds: float) -> None:
        """Pauses, and goes back, if it is negative, or on [s] within the run."""
        self.seek(self.simulation.time + seconds)

    @property
    def takes_commands(self) -> bool:
        """False in the past, until the run goes on: keys drive no robot there."""
        return not (self.playback.is_paused and self.timeline.is_in_past)

    def reset(self) -> None:
        """Rebuilds the world as it was loaded."""
        self.simulation.reset()
        self.drive.forget()
        self._trail.clear()
        self.message = "reset"

    def _step(self) -> None:
        try:
            self.simulation.step()
        except FlatlandError as error:
            self.playback.is_paused = True
            self.message = str(error)
        self._trail.note(self.chosen, self.shows_trail)

    # The model that is chosen

    def choose(self, name: str) -> None:
        """Chooses a model to be driven and followed."""
        if name != self.chosen:
            self.chosen = name
            self._trail.clear()

    def choose_next(self, step: int = 1) -> None:
        """Follows the chosen model; if it is followed already, the next robot of the world.

        Robots are the models that have a drive; or all models, if none has one.
        """
        names = self._robots()
        if self.chosen in names:
            step = step if self.is_following else 0
            self.choose(names[(names.index(self.chosen) + step) % len(names)])
        elif names:
            self.choose(names[0])
        self.follow()

    def choose_at(self, pixel: Point) -> None:
        """Chooses the model at a pixel, if there is one, and follows it."""
        x, y = self.view.position(pixel)
        reach = _REACH / self.view.scale
        distances = {
            name: math.dist((x, y), handle.model.pose[:2]) - handle.model.radius
            for name, handle in self.simulation.models.items()
        }
        name = min(distances, key=lambda each: distances[each], default="")
        if name and distances[name] <= reach:
            self.choose(name)
            self.follow()

    def follow(self) -> None:
        """Keeps the chosen model in the middle, at a scale at which it can be seen well."""
        self.is_following = self.chosen in self.simulation.models
        if self.is_following:
            least = self.view.size[0] / _FOLLOW_WIDTH
            if self.view.scale < least:
                self.view = View.around(self.view.center, least, self.view.size)

    def toggle_follow(self) -> None:
        """Follows the chosen model, or leaves the view where it is."""
        if self.is_following:
            self.is_following = False
        else:
            self.follow()

    # The view

    def pan(self, columns: int, rows: int) -> None:
        """Drags the world by some pixels; no model is followed any more."""
        self.is_following = False
        self.view = self.view.panned(columns, rows)

    def zoom(self, clicks: float, pixel: Point) -> None:
        """Enlarges what is at a pixel, by so many clicks of the mouse's wheel."""
        if self.is_following:
            pixel = (self.view.size[0] / 2, self.view.size[1] / 2)
        self.view = self.view.zoomed(_ZOOM**clicks, pixel)

    def show_all(self) -> None:
        """Shows the whole world."""
        self.is_following = False
        self.view = self._renderer.view(self.view.size)

    def resize(self, size: Size) -> None:
        """Changes the size of the picture [px]."""
        self.view = self.view.resized(size)

    # The picture

    def image(self) -> Image.Image:
        """The world as it is now."""
        handle = self.simulation.models.get(self.chosen)
        if handle is not None and self.is_following:
            self.view = self.view.centered(handle.model.pose[:2])
        image = self._renderer.image(
            self.view,
            sensors=self.shows_sensors,
            names=self.shows_names,
            trails=self._trail.lines if self.shows_trail else (),
        )
        if handle is not None:
            model = handle.model
            radius = model.radius + _RING_GAP / self.view.scale
            ImageCanvas(image, self.view).disc(
                model.pose[:2], radius, outline=_RING, width=_RING_WIDTH
            )
        return image

    def save_picture(self, folder: Path) -> None:
        """Saves the picture under a name that is not taken; the message says which."""
        number = 1
        while (folder / f"flatland_{number}.png").exists():
            number += 1
        path = folder / f"flatland_{number}.png"
        try:
            self.image().save(path)
            self.message = f"saved {path.name}"
        except OSError as error:
            self.message = f"{path.name} cannot be written: {error.strerror}"

    def status(self) -> Tuple[str, str]:
        """The status line: of the simulation, and of the chosen model."""
        playback = self.playback
        state = "paused" if playback.is_paused else f"{playback.measured_rate:.2f} x real time"
        if not playback.is_paused and playback.rate != 1.0:
            state += f" of {playback.rate:g}"
        later = f" of {self.timeline.end:.2f} s" if self.timeline.is_in_past else " s"
        world = f"{self.simulation.time:.2f}{later}   {state}"
        failures = self.simulation.world.plugin_failures
        if failures:
            world += f"   failed: {', '.join(failure.label for failure in failures)}"
        if self.message:
            world += f"   {self.message}"
        handle = self.simulation.models.get(self.chosen)
        if handle is None:
            return world, ""
        x, y, yaw = handle.pose
        forwards, left, turn = handle.local_velocity
        speed = f"{forwards:.2f} m/s" if abs(left) < 5e-3 else f"{forwards:.2f}, {left:.2f} m/s"
        degrees = math.degrees(yaw)
        place = f"x {x:.2f}  y {y:.2f}  yaw {degrees:.0f}\N{DEGREE SIGN}"
        return world, f"{handle.name}   {place}   {speed}  {turn:.2f} rad/s"

    def _robots(self) -> List[str]:
        """The names of the models that have a drive; of all models, if none has one."""
        names = list(self.simulation.models)
        return [name for name in names if first_drive(self.simulation, name)] or names
