"""The window, by pygame: draws what the viewer shows, and tells it of keys and the mouse."""

import os
import sys
from pathlib import Path
from typing import Any, Callable, Dict, Optional, Tuple

from flatland2d.viewer.display_libraries import missing_libraries
from flatland2d.viewer.keys import KEYS
from flatland2d.viewer.viewer import Viewer
from flatland_server.exceptions import MissingPackageError
from flatland_teleop.driving_keys import DIRECTIONS, direction

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
os.environ.setdefault("SDL_VIDEO_X11_WMCLASS", "flatland")
try:
    import pygame
except ImportError:
    raise MissingPackageError(
        "a window needs pygame: pip install 'flatland2d[view]', or apt install python3-pygame"
    ) from None

_FRAME_RATE = 30
_FONTS = "dejavusans,notosans,liberationsans,helvetica,arial"  # or else pygame's own
_FONT_SIZE = 14  # px
_BAR_HEIGHT = 26  # px
_TIMELINE_HEIGHT = 22  # px
_BARS_HEIGHT = _TIMELINE_HEIGHT + _BAR_HEIGHT
_MARGIN = 16  # px: of the timeline, at its ends
_KNOB = 7  # px
_TEXT = (32, 32, 32)
_PALE = (110, 110, 110)
_BAR = (225, 225, 223)
_TRACK = (190, 190, 188)
_PAST = (70, 110, 170)
_CLICK = 4  # px; a mouse that moves further while its button is down is dragging
_LEAST_SIZE = (320, 240)
_DRIVING = {
    name: getattr(pygame, f"K_{name if len(name) == 1 else name.upper()}") for name in DIRECTIONS
}
"""Pygame's keys that drive, by their names."""
_WITHOUT_SCREEN = {"dummy", "evdev", "offscreen"}
"""SDL's drivers that show nothing, which it may choose where there is no screen."""


class Window:
    """A window on a simulation.

    Args:
        viewer: what is shown, and what keys do.
        title: of the window.

    Raises:
        FlatlandError: there is no screen.
    """

    def __init__(self, viewer: Viewer, title: str) -> None:
        self._viewer = viewer
        self._is_open = True
        self._pressed: Optional[Tuple[int, int]] = None  # where the left button went down
        self._is_dragging = False
        self._is_seeking = False  # the button is down on the timeline
        self._sought: Optional[int] = None  # the column that it was moved to, in this frame
        width, height = viewer.view.size
        self._screen = _open_screen((width, height + _BARS_HEIGHT))
        pygame.display.set_caption(title)
        pygame.key.set_repeat()  # held keys drive; they do not repeat
        self._font = pygame.font.SysFont(_FONTS, _FONT_SIZE)
        self._actions = self._key_actions()
        self._clock = pygame.time.Clock()

    @property
    def is_open(self) -> bool:
        """True if the user has not closed it yet."""
        return self._is_open

    def run(self) -> None:
        """Shows the simulation until the window is closed."""
        try:
            while self._is_open:
                self.show_frame()
        except KeyboardInterrupt:
            pass  # Ctrl-C in the terminal is as good as closing the window
        finally:
            self.close()

    def show_frame(self) -> None:
        """Waits until the next frame is due, makes the steps that are due by then, and shows it."""
        elapsed = self._clock.tick(_FRAME_RATE) / 1000.0
        for event in pygame.event.get():
            self._handle(event)
        self._seek()
        self._drive()
        self._viewer.advance(elapsed)
        self._draw()

    def close(self) -> None:
        """Closes the window."""
        self._is_open = False
        pygame.quit()

    def _key_actions(self) -> Dict[int, Callable[[], None]]:
        viewer = self._viewer
        return {
            pygame.K_SPACE: viewer.toggle_pause,
            pygame.K_PERIOD: viewer.single_step,
            pygame.K_KP_PERIOD: viewer.single_step,
            pygame.K_F10: viewer.single_step,
            pygame.K_COMMA: lambda: viewer.seek_by(-viewer.simulation.step_size),
            pygame.K_END: lambda: viewer.seek(viewer.timeline.end),
            pygame.K_r: viewer.reset,
            pygame.K_f: viewer.toggle_follow,
            pygame.K_HOME: viewer.show_all,
            pygame.K_p: lambda: viewer.save_picture(Path.cwd()),
            pygame.K_l: lambda: self._toggle("shows_sensors"),
            pygame.K_n: lambda: self._toggle("shows_names"),
            pygame.K_t: lambda: self._toggle("shows_trail"),
            pygame.K_h: lambda: self._toggle("shows_help"),
            pygame.K_F1: lambda: self._toggle("shows_help"),
            pygame.K_ESCAPE: self._leave,
        }

    def _toggle(self, option: str) -> None:
        setattr(self._viewer, option, not getattr(self._viewer, option))

    def _leave(self) -> None:
        """Leaves the help, or else stops following."""
        if not self._viewer.shows_help:
            self._viewer.is_following = False
        self._viewer.shows_help = False

    def _close(self) -> None:
        self._is_open = False

    def _handle(self, event: Any) -> None:
        if event.type == pygame.QUIT:
            self._close()
        elif event.type == pygame.KEYDOWN:
            self._on_key(event)
        elif event.type == pygame.VIDEORESIZE:
            width, height = (max(side) for side in zip(event.size, _LEAST_SIZE))
            self._viewer.resize((width, height - _BARS_HEIGHT))
        elif event.type == pygame.MOUSEWHEEL:
            self._viewer.zoom(event.y, pygame.mouse.get_pos())
        elif event.type == pygame.MOUSEBUTTONDOWN and event.button == 1:
            if event.pos[1] >= self._viewer.view.size[1]:
                self._is_seeking = event.pos[1] < self._viewer.view.size[1] + _TIMELINE_HEIGHT
                self._sought = event.pos[0]
            else:
                self._pressed, self._is_dragging = event.pos, False
        elif event.type == pygame.MOUSEMOTION and self._is_seeking:
            self._sought = event.pos[0]
        elif event.type == pygame.MOUSEMOTION and self._pressed is not None:
            self._on_drag(event)
        elif event.type == pygame.MOUSEBUTTONUP and event.button == 1:
            if self._pressed is not None and not self._is_dragging:
                self._viewer.choose_at(event.pos)
            self._pressed, self._is_seeking = None, False

    def _on_key(self, event: Any) -> None:
        self._viewer.message = ""
        if event.mod & pygame.KMOD_CTRL and event.key == pygame.K_q:
            self._close()
        elif event.key == pygame.K_TAB:
            self._viewer.choose_next(-1 if event.mod & pygame.KMOD_SHIFT else 1)
        elif event.key in (pygame.K_PAGEUP, pygame.K_PAGEDOWN):
            seconds = 1.0 if event.mod & pygame.KMOD_SHIFT else 10.0
            self._viewer.seek_by(-seconds if event.key == pygame.K_PAGEUP else seconds)
        elif event.unicode == "+":  # a key of its own, or with Shift, depending on the keyboard
            self._viewer.playback.faster()
        elif event.unicode == "-":
            self._viewer.playback.slower()
        elif event.key in self._actions:
            self._actions[event.key]()

    def _on_drag(self, event: Any) -> None:
        assert self._pressed is not None
        if self._is_dragging:
            self._viewer.pan(*event.rel)
            return
        moved = event.pos[0] - self._pressed[0], event.pos[1] - self._pressed[1]
        if max(map(abs, moved)) > _CLICK:
            self._is_dragging = True
            self._viewer.pan(*moved)

    def _seek(self) -> None:
        """Shows the moment at which the mouse holds the timeline's knob."""
        if self._sought is not None:
            timeline, width = self._viewer.timeline, self._viewer.view.size[0]
            fraction = (self._sought - _MARGIN) / max(width - 2 * _MARGIN, 1)
            self._viewer.seek(timeline.time_at(fraction))
            self._sought = None

    def _drive(self) -> None:
        """Commands the chosen robot by the keys that are held down."""
        if not self._viewer.takes_commands:
            return
        held = pygame.key.get_pressed()
        self._viewer.drive.command(
            self._viewer.chosen,
            direction(name for name, key in _DRIVING.items() if held[key]),
            is_slow=bool(pygame.key.get_mods() & pygame.KMOD_SHIFT),
        )

    def _draw(self) -> None:
        image = self._viewer.image()
        picture = pygame.image.frombuffer(image.tobytes(), image.size, "RGB")
        self._screen.blit(picture, (0, 0))
        self._draw_timeline(image.size)
        self._draw_status(image.size)
        if self._viewer.shows_help:
            self._draw_help()
        pygame.display.flip()

    def _draw_timeline(self, size: Tuple[int, int]) -> None:
        """A line from the first to the last moment, and a knob at the one that is shown."""
        width, top = size
        pygame.draw.rect(self._screen, _BAR, (0, top, width, _TIMELINE_HEIGHT))
        row, length = top + _TIMELINE_HEIGHT // 2 + 2, width - 2 * _MARGIN
        knob = _MARGIN + round(self._viewer.timeline.fraction * length)
        pygame.draw.rect(self._screen, _TRACK, (_MARGIN, row - 2, length, 4), border_radius=2)
        pygame.draw.rect(self._screen, _PAST, (_MARGIN, row - 2, knob - _MARGIN, 4))
        pygame.draw.circle(self._screen, _PAST, (knob, row), _KNOB)

    def _draw_status(self, size: Tuple[int, int]) -> None:
        width, top = size[0], size[1] + _TIMELINE_HEIGHT
        pygame.draw.rect(self._screen, _BAR, (0, top, width, _BAR_HEIGHT))
        left, right = (self._font.render(text, True, _TEXT) for text in self._viewer.status())
        row = top + (_BAR_HEIGHT - left.get_height()) // 2
        hint = self._font.render("H: help", True, _PALE)
        self._screen.blit(left, (10, row))
        self._screen.blit(hint, (width - hint.get_width() - 10, row))
        self._screen.blit(right, (width - hint.get_width() - right.get_width() - 40, row))

    def _draw_help(self) -> None:
        lines = [(self._font.render(keys, True, _TEXT), action) for keys, action in KEYS]
        column = max(keys.get_width() for keys, _ in lines) + 20
        rows = [(keys, self._font.render(action, True, _TEXT)) for keys, action in lines]
        row_height = self._font.get_linesize() + 6
        width = column + max(action.get_width() for _, action in rows) + 32
        box = pygame.Surface((width, row_height * len(rows) + 24), pygame.SRCALPHA)
        box.fill((250, 250, 249, 235))
        pygame.draw.rect(box, (190, 190, 188), box.get_rect(), 1)
        for number, (keys, action) in enumerate(rows):
            row = 12 + number * row_height
            box.blit(keys, (16, row))
            box.blit(action, (16 + column, row))
        self._screen.blit(box, (16, 16))


def _open_screen(size: Tuple[int, int]) -> Any:
    """Opens the window.

    Raises:
        FlatlandError: there is no screen.
    """
    asked = os.environ.get("SDL_VIDEODRIVER")
    displays = [os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")]
    problem = ""
    if sys.platform == "linux" and not asked and not any(displays):
        problem = "DISPLAY is not set"
    else:
        try:
            pygame.display.init()
            pygame.font.init()
            if not asked and pygame.display.get_driver() in _WITHOUT_SCREEN:
                problem = f"the display {displays[0] or displays[1]} cannot be opened"
                missing = missing_libraries() if displays[0] else ""
                problem += f", since {missing}" if missing else ""
            else:
                return pygame.display.set_mode(size, pygame.RESIZABLE)
        except pygame.error as error:
            problem = str(error)
    pygame.quit()
    raise MissingPackageError(
        f"there is no screen to open a window on: {problem}; `flatland render` draws into a file"
    )
