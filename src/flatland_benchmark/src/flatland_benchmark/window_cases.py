"""Cases with the window under Xvfb: its cost without a graphics card.

Plain rviz, which draws at each of its updates, is measured beside it with the same world.
"""

import sys
import tempfile
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Dict, Iterator, Tuple

import numpy as np
from PIL import ImageGrab

from flatland_benchmark.case import Case, Figures
from flatland_benchmark.process import Process
from flatland_benchmark.robot_worlds import write_world
from flatland_benchmark.scenes import write_noisy_map
from flatland_benchmark.server_process import ServerProcess

_REAL_TIME = 200.0  # steps per second
_SETTLING = 4.0  # s
_MEASURING = 8.0  # s
_SPECKS = 0.1
"""Share of black pixels in a map of noise, of 4.7 million segments."""

_MAP_LIMIT = 600.0  # s
_BACKGROUND = (238, 238, 236)

_MODELS = "/flatland_server/debug/models"

_VIEWERS: Dict[str, Tuple[str, ...]] = {
    "window": ("rosrun", "flatland_viz", "flatland_viz"),
    "rviz": ("rviz", "-d", "flatland.rviz"),
}


@contextmanager
def _server(world: Path, limit: float = 60.0) -> Iterator[Tuple[ServerProcess, str]]:
    """A server, and the name of an X display for viewers of its world."""
    with ServerProcess(
        world, _REAL_TIME, parameters=("_map_to_odom:=true",), limit=limit
    ) as server:
        yield server, server.start_screen()


def _open(server: ServerProcess, kind: str, display: str) -> Process:
    """Opens a window or plain rviz, which draw without a graphics card."""
    command = list(_VIEWERS[kind])
    if kind == "rviz":
        found = server.call("rospack", ["rospack", "find", "flatland_viz"]).strip()
        command[-1] = str(Path(found) / "rviz" / "flatland.rviz")
    return server.start(kind, command, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1")


def _open_and_wait(server: ServerProcess, kind: str, display: str) -> Process:
    """The same; returns when it has subscribed to the models."""
    former = server.subscribers(_MODELS)
    viewer = _open(server, kind, display)
    server.wait_until(lambda: server.subscribers(_MODELS) - former, kind)
    return viewer


def watch(worlds: Path, robots: int, is_paused: bool = False) -> Figures:
    """Robots that drive in circles, or stand in a paused simulation, watched in turn by both."""
    figures: Figures = {}
    with tempfile.TemporaryDirectory(prefix="flatland_benchmark_") as folder:
        world = write_world(Path(folder), worlds, robots)
        with _server(world) as (server, display):
            names = [f"robot_{i}" for i in range(robots)]
            server.call("driver", [sys.executable, "-m", "flatland_benchmark.drive_robots", *names])
            if is_paused:
                server.call("pause", ["rosservice", "call", "/pause"])
            for kind in _VIEWERS:
                viewer = _open_and_wait(server, kind, display)
                server.settle(_SETTLING)
                processes = {kind: viewer, f"server, with {kind}": server.server}
                before = {name: one.cpu_seconds for name, one in processes.items()}
                begin = time.monotonic()
                server.settle(_MEASURING)
                seconds = time.monotonic() - begin
                for name, one in processes.items():
                    share = (one.cpu_seconds - before[name]) / seconds
                    figures[f"{name} [% of a core]"] = 100.0 * share
                figures[f"{kind}, memory [MB]"] = viewer.memory
                server.end(viewer)
    return figures


def show_noise(worlds: Path) -> Figures:
    """The window on a map of 4000 x 4000 pixels of noise: time until it shows, memory."""
    with tempfile.TemporaryDirectory(prefix="flatland_benchmark_") as folder:
        map_file = write_noisy_map(Path(folder), _SPECKS)
        world = Path(folder) / "world.yaml"
        world.write_text(
            "properties: {}\n"
            f"layers: [{{name: map, map: {map_file}, color: [0.4, 0.4, 0.4, 1]}}]\n"
        )
        with _server(world, _MAP_LIMIT) as (server, display):
            begin = time.monotonic()
            window = _open(server, "window", display)
            server.wait_until(lambda: _shows_walls(display), "walls")
            seconds = time.monotonic() - begin
            server.settle(_SETTLING)
            return {
                "server starts [s]": server.seconds_to_start,
                "walls show [s]": seconds,
                "window, peak memory [MB]": window.peak_memory,
                "server, peak memory [MB]": server.server.peak_memory,
                "server, memory [MB]": server.server.memory,
            }


def _shows_walls(display: str) -> bool:
    """True if most of the window's middle is covered by something."""
    middle = np.asarray(ImageGrab.grab(xdisplay=display).convert("RGB"))[300:500, 500:800]
    covered = (middle != _BACKGROUND).any(axis=2) & (middle != 0).any(axis=2)
    return bool(covered.mean() > 0.5)


WINDOW_CASES: Tuple[Case, ...] = (
    Case(
        "window_paused",
        "the window on a paused simulation, and plain rviz",
        partial(watch, robots=1, is_paused=True),
    ),
    Case("window_1", "the window with a driving robot, and plain rviz", partial(watch, robots=1)),
    Case("window_30", "the same with 30 robots", partial(watch, robots=30)),
    Case("window_noise", "the window on a map of 4000 x 4000 pixels of noise", show_noise),
)
