"""Draws the figures of the guide.

usage: figures.py [--check]

They are generated from the code: imports of packages, names of hooks, due times of timers, bytes
of a message, walls hit by a scan. `--check` lists the figures that are out of date.
"""

import ast
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Callable, Dict, List, Set, Tuple

import numpy as np
from blocks import blocks_of
from svg import BLUE, GREY, ORANGE, RED, TEAL, Svg

from flatland2d import Simulation, messages
from flatland_plugins.scan_writer import ScanWriter
from flatland_server import UpdateTimer
from flatland_server.plugins.plugin import CONTACT_HOOKS, STEP_HOOKS

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"

Box = Tuple[str, str, int, int, int]
"""A package, its description, and its box: row from the top, left edge and width."""

PACKAGES: List[Box] = [
    ("flatland_viz", "the window and rviz tools", 0, 20, 210),
    ("flatland_server.ros", "the node: topics, services, time", 1, 20, 210),
    ("flatland_plugins", "drives and sensors, found by name", 1, 246, 210),
    ("flatland_gym", "environments for learning", 0, 472, 210),
    ("flatland2d", "simulations, batches, sweeps", 1, 472, 210),
    ("flatland_navigation", "planner, follower, their nodes", 2, 698, 210),
    ("flatland_server", "files, worlds, steps, plugins; no ROS", 3, 20, 888),
    ("flatland_server._core", "bindings (pybind11), C++ core, Box2D", 4, 20, 888),
]
ROW, HEIGHT, TOP = 92, 52, 34


def imported(package: str) -> Set[str]:
    """The packages of `PACKAGES` that a package imports."""
    names = {name for name, *_ in PACKAGES}
    folder = ROOT / "src" / package.partition(".")[0] / "src" / package.replace(".", "/")
    found = set()
    for path in folder.rglob("*.py"):
        if package == "flatland_server" and "ros" in path.relative_to(folder).parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                modules = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            else:
                continue
            for module in modules:
                owners = [name for name in names if f"{module}.".startswith(f"{name}.")]
                found.update(sorted(owners, key=len)[-1:])
    return found - {package}


def architecture() -> Svg:
    """The packages and their imports."""
    drawing = Svg(928, 468, "The packages of Flatland and what each imports")
    rows = {name: row for name, _, row, _, _ in PACKAGES}
    places = {name: (x, TOP + ROW * row, width) for name, _, row, x, width in PACKAGES}
    for name, *_ in PACKAGES:
        for other in sorted(imported(name)):
            if rows[other] <= rows[name]:
                raise ValueError(f"{name} imports {other}, which is not below it in the figure")
            (x, y, width), (left, top, wide) = places[name], places[other]
            begin = x + width / 2
            end = min(max(begin, left + 40), left + wide - 40)
            drawing.line([(begin, y + HEIGHT), (end, top)], arrow=True)
    x, y, width = places["flatland_viz"]
    left, top, _ = places["flatland_server.ros"]
    drawing.line([(x + width / 2, y + HEIGHT), (left + width / 2, top)], dashed=True, arrow=True)
    drawing.text(x + width / 2 + 10, top - 14, "topics and services alone", 13, GREY, "start")
    for name, text, row, left, wide in PACKAGES:
        top = TOP + ROW * row
        color = ORANGE if name.endswith("_core") else BLUE if name == "flatland_server" else TEAL
        drawing.box(left, top, wide, HEIGHT, color)
        drawing.text(left + wide / 2, top + 22, name, 16, bold=True)
        drawing.text(left + wide / 2, top + 42, text, 13, GREY)
    drawing.text(20, 18, "An arrow leads to what is imported; none leads up.", 13, GREY, "start")
    return drawing


def step() -> Svg:
    """The life of a step: which hooks are called, and by which part."""
    prepare, before, after = STEP_HOOKS
    contacts = list(CONTACT_HOOKS)
    phases = [
        (["callbacks", "commands and services", "between steps"], GREY, 0, 1),
        ([prepare, "lidars scan together", "t"], BLUE, 1, 1),
        ([before, "sensors publish", "t"], BLUE, 2, 1),
        (["physics", "drives, tweens, bodies", "t to t + dt"], ORANGE, 3, 1),
        ([after, "what the step did", "t + dt"], BLUE, 3, 2),
        (["deferred actions", "spawns, moves, deletions", "t + dt"], GREY, 2, 2),
        (["flush", "all transforms on /tf", "t + dt"], GREY, 1, 2),
    ]
    column, row, width, height = 192, 106, 172, 72
    drawing = Svg(4 * column + 4, 3 * row - 4, "The life of a step")
    places = [(12 + column * x, 14 + row * y) for _, _, x, y in phases]
    for (lines, color, _, _), (x, y) in zip(phases, places):
        drawing.box(x, y, width, height, color)
        drawing.text(x + width / 2, y + 23, lines[0], 14, bold=True)
        drawing.text(x + width / 2, y + 43, lines[1], 13)
        drawing.text(x + width / 2, y + 61, lines[2], 12, GREY)
    for (x, y), (other, below) in zip(places, places[1:]):
        if y != below:  # down
            drawing.line([(x + width / 2, y + height), (x + width / 2, below)], arrow=True)
        else:
            side = width if x < other else 0
            drawing.line(
                [(x + side, y + height / 2), (other + width - side, y + height / 2)], arrow=True
            )
    (first, top), (last, bottom) = places[0], places[-1]
    drawing.line(
        [(last, bottom + 36), (first + 86, bottom + 36), (first + 86, top + height)], arrow=True
    )
    drawing.text(first + 92, bottom + 56, "the next step", 12, GREY, "start")
    left, right = places[2][0] - 80, places[3][0] + width
    drawing.box(left, 8, right - left, 60, RED)
    drawing.text((left + right) / 2, 32, ", ".join(contacts), 14, bold=True)
    drawing.text((left + right) / 2, 53, "of contacts, called by the solver", 13)
    drawing.line([(places[3][0] + 86, top), (places[3][0] + 86, 68)], arrow=True)
    return drawing


def lidar() -> Svg:
    """A scan in the office: all walls, and the walls that it hits."""
    with Simulation("office", seed=1) as simulation:
        walls = simulation.world.layers[0].segments
        robot = simulation.models["turtlebot"]
        ranges = robot.sensors["laser"].read()
        x0, y0, _ = robot.pose
    x0 += 0.05
    angles = -2.356194490192345 + 0.004363323129985824 * np.arange(len(ranges))
    ends = np.column_stack([x0 + ranges * np.cos(angles), y0 + ranges * np.sin(angles)])
    ends = ends[np.isfinite(ends).all(axis=1)]
    begin, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    length = np.maximum(np.hypot(*along.T), 1e-9)
    met = np.zeros(len(walls), dtype=bool)
    for point in ends:
        offset = point - begin
        distance = np.abs(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]) / length
        place = (offset * along).sum(axis=1) / length**2
        near = (distance < 0.01) & (place > -0.01) & (place < 1.01)
        met |= near
    scale, left, top = 17.0, 24.0, 12.0
    low, high = walls.reshape(-1, 2).min(axis=0), walls.reshape(-1, 2).max(axis=0)

    def at(point: np.ndarray) -> Tuple[float, float]:
        return left / 2 + (point[0] - low[0]) * scale, top + (high[1] - point[1]) * scale

    size = ((high - low) * scale + (left, 60)).astype(int)
    drawing = Svg(int(size[0]), int(size[1]), "A scan in the office")
    drawing.area([at(np.array([x0, y0])), *map(at, ends)], RED, 0.15)
    drawing.segments([(at(wall[:2]), at(wall[2:])) for wall in walls[~met]], "#9e9e9e", 0.8)
    drawing.segments([(at(wall[:2]), at(wall[2:])) for wall in walls[met]], RED, 2.2)
    drawing.dot(*at(np.array([x0, y0])), radius=4, color=BLUE)
    drawing.text(
        12,
        size[1] - 18,
        f"{len(ranges)} beams end on {met.sum()} of {len(walls)} walls; "
        "the others are passed over, most of them by boxes at a time",
        20,
        anchor="start",
    )
    return drawing


def schedule() -> Svg:
    """Calls of plugins of several rates at steps of 5 ms; one of them is idle at first."""
    rates = [("no rate", float("inf")), ("50 Hz", 50.0), ("30 Hz", 30.0), ("30 Hz", 30.0)]
    steps, dt = 41, 5_000_000
    drawing = Svg(860, 196, "Which plugins are called in which step")
    legend = "steps of 5 ms; a dot is a call; grey: due, but idle until 80 ms, so not called"
    drawing.text(12, 20, legend, 12, GREY, "start")
    for row, (name, rate) in enumerate(rates):
        y = 50 + 34 * row
        timer = UpdateTimer(rate)
        drawing.text(12, y + 4, name, 13, anchor="start", bold=True)
        drawing.line([(90, y), (840, y)], "#bdbdbd")
        for number in range(steps):
            if timer.check_update_at(number * dt):
                is_idle = row == len(rates) - 1 and number < 16
                color = "#bdbdbd" if is_idle else (BLUE, TEAL, ORANGE, RED)[row]
                drawing.dot(90 + 18.5 * number, y, 4, color)
    for number in range(0, steps, 10):
        drawing.text(90 + 18.5 * number, 184, f"{number * 5} ms", 11, GREY)
    return drawing


def message() -> Svg:
    """The bytes of a scan."""
    writer = ScanWriter("laser", angle_min=-1.0, angle_max=1.0, angle_increment=1.0, range_max=9.0)
    ranges = np.array([1.0, 2.5, np.inf], dtype=np.float32)
    data = writer.data(1_250_000_000, ranges, np.empty(0, np.float32))
    read = messages.get("sensor_msgs/LaserScan")()
    read.deserialize(data)
    assert list(read.ranges) == list(ranges)
    parts = [
        ("number, time", 12, ORANGE),
        ("frame, angles, limits: packed once", 4 + len("laser") + 28, GREY),
        ("3 ranges: copied from the scan", 4 + 4 * len(ranges), ORANGE),
        ("intensities", 4, GREY),
    ]
    assert sum(size for _, size, _ in parts) == len(data)
    per_row, cell = 22, 34
    rows = -(-len(data) // per_row)
    drawing = Svg(per_row * cell + 24, rows * 34 + 82, "The bytes of a LaserScan")
    colors = [color for _, size, color in parts for _ in range(size)]
    for index, (byte, color) in enumerate(zip(data, colors)):
        x, y = 12 + index % per_row * cell, 12 + index // per_row * 34
        drawing.box(x, y, cell - 3, 26, color)
        drawing.text(x + cell / 2 - 2, y + 18, f"{byte:02x}", 12)
    for index, (name, size, color) in enumerate(parts):
        x, y = 12 + 340 * (index % 2), rows * 34 + 26 + 24 * (index // 2)
        drawing.box(x, y, 14, 14, color)
        drawing.text(x + 22, y + 12, f"{name} ({size} bytes)", 12, anchor="start")
    return drawing


DRAWINGS: Dict[str, Callable[[], Svg]] = {
    "architecture": architecture,
    "step": step,
    "lidar": lidar,
    "schedule": schedule,
    "message": message,
}


def outdated() -> List[str]:
    """The drawings that differ from those of docs/images."""
    files = {name: IMAGES / f"{name}.svg" for name in DRAWINGS}
    return [
        name
        for name, draw in DRAWINGS.items()
        if not files[name].exists() or not _look_alike(files[name].read_text(), str(draw()))
    ]


def _look_alike(one: str, other: str) -> bool:
    """True if drawings differ by the rounding of a pixel's tenth only, as on another processor."""
    words, others = (re.split(r"(-?\d+\.\d)\b", text) for text in (one, other))
    if words[::2] != others[::2]:
        return False
    return all(abs(float(a) - float(b)) < 0.15 for a, b in zip(words[1::2], others[1::2]))


def render_tutorials() -> None:
    """The pictures of tutorials: their files, rendered as the pages say."""
    page = ROOT / "docs" / "tutorials"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for tutorial, world, options in (
            ("world", "rooms.world", {"sensors": True}),
            ("robot", "world", {"sensors": True}),
            ("own_node", "", {}),
            ("people_and_doors", "people.world", {"names": True}),
        ):
            for block in blocks_of(page / f"{tutorial}.md"):
                if block.file:
                    (folder / block.file).write_text(block.text)
                elif block.language == "python" and tutorial == "world":
                    exec(block.text.replace('"map.png"', f'"{folder}/map.png"'))
                elif "way.png" in block.text:
                    run = [sys.executable, "-c", block.text]
                    subprocess.run(run, cwd=folder, check=True, stdout=subprocess.DEVNULL)
                    shutil.move(folder / "way.png", IMAGES / "tutorial_way.png")
            if not world:
                continue
            with Simulation(folder / f"{world}.yaml", seed=2) as simulation:
                if tutorial == "people_and_doors":
                    simulation.publish("/door/tween_trigger", messages.get("std_msgs/Bool")(True))
                    simulation.step(700)
                short = tutorial.partition("_")[0]
                size = (720, 220 if short == "people" else 440)
                simulation.save_picture(IMAGES / f"tutorial_{short}.png", size=size, **options)
    with Simulation("office", seed=1) as simulation:
        simulation.models["turtlebot"].command(0.5, 0.2)
        simulation.step(400)
        simulation.save_picture(
            IMAGES / "render.png", size=(900, 500), follow="turtlebot", sensors=True
        )


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit("\n".join(outdated()) or None)
    for each, function in DRAWINGS.items():
        (IMAGES / f"{each}.svg").write_text(str(function()), encoding="utf-8")
    render_tutorials()
