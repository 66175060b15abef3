"""Shared by the tests of files: a folder of valid files, which a test may then change."""

import re
import textwrap
from pathlib import Path
from typing import Any, Union

import hypothesis
import pytest
from PIL import Image, ImageDraw

from flatland_server.exceptions import FlatlandError
from flatland_server.geometry import Pose
from flatland_server.plugins.declarations import read_declarations
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.simulation.world import World
from flatland_server.transport.local_transport import LocalTransport

# The same cases in every run, and no database of examples on disk.
hypothesis.settings.register_profile("flatland", derandomize=True, database=None, deadline=None)
hypothesis.settings.load_profile("flatland")

GOOD = {
    "world.yaml": """\
properties: {velocity_iterations: 10, position_iterations: 10}
layers:
  - name: [map, walls]
    map: map.yaml
    color: [0.4, 0.4, 0.4, 1]
    properties: {debug: {min_z: 0, max_z: 1}}
  - {name: lines, map: lines.yaml}
  - name: floor
models:
  - name: robot
    namespace: r1
    pose: [1, 2, 0.5]
    model: robot.model.yaml
""",
    "map.yaml": """\
image: map.png
resolution: 0.05
origin: [-1, -2, 0.5]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
""",
    "lines.yaml": """\
type: line_segments
data: lines.dat
scale: 0.1
origin: [-1.2, -5, 1.23]
""",
    "lines.dat": """\
0 0 1 1
2 3 -1 2
""",
    "robot.model.yaml": """\
bodies:
  - name: base
    enabled: true
    pose: [0, 0, 0]
    type: dynamic
    color: [1, 1, 1, 0.5]
    linear_damping: 0
    angular_damping: 0
    footprints:
      - type: circle
        radius: 0.5
        center: [0, 0]
        density: 1
        friction: 0.1
        restitution: 0
        layers: [map, walls]
        collision: true
        sensor: false
  - name: wheel
    footprints:
      - type: polygon
        points: [[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]
        density: 1
joints:
  - type: revolute
    name: hinge
    limits: [-1, 1]
    collide_connected: false
    bodies:
      - {name: base, anchor: [0.5, 0]}
      - {name: wheel, anchor: [0, 0]}
  - type: weld
    name: hub
    enabled: false
    angle: 0
    frequency: 0
    damping: 0
    bodies:
      - {name: base, anchor: [0, 0]}
      - {name: wheel, anchor: [0, 0]}
plugins:
  - type: DiffDrive
    name: drive
    body: base
    linear_dynamics: {velocity_limit: 1}
  - type: Laser
    name: laser
    body: base
    range: 10
    angle: {min: -1, max: 1, increment: 0.1}
    ignore_bodies: [wheel]
""",
}

PLUGINS = Path(__file__).resolve().parents[3] / "flatland_plugins" / "flatland_plugins.xml"


class Files:
    """A folder of world, model and map files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        # The built-in plugins alone, whatever else is on ROS_PACKAGE_PATH.
        self.declarations = read_declarations("flatland_plugins", PLUGINS)
        self.loader = PluginLoader(self.declarations)

    def write(self, name: str, content: Union[str, bytes]) -> Path:
        """Writes a file; a string may be indented as a whole."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, str):
            content = textwrap.dedent(content).lstrip("\n").encode()
        path.write_bytes(content)
        return path

    def write_good_ones(self) -> None:
        """Writes a world that loads: an image, line segments and a robot with two plugins."""
        for name, text in GOOD.items():
            self.write(name, text)
        self.draw_map("map.png")

    def draw_map(self, name: str, size: int = 40) -> None:
        """Writes an image of a white room with a black border and a black block."""
        image = Image.new("L", (size, size), 255)
        draw = ImageDraw.Draw(image)
        draw.rectangle([0, 0, size - 1, size - 1], outline=0)
        draw.rectangle([size // 4, size // 4, size // 2, size // 2], fill=0)
        image.save(self.folder / name)

    def edit(self, name: str, old: str, new: str) -> None:
        """Replaces the first occurrence of a string in a file."""
        path = self.folder / name
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    def load(self, name: str = "world.yaml", **options: Any) -> World:
        """Loads a world file."""
        return World.from_file(self.folder / name, **{"loader": self.loader, **options})

    def spawn(self, text: str, **params: Any) -> World:
        """An empty world into which the model `robot` of this file was spawned."""
        path = self.write("spawned.model.yaml", text)
        empty = self.write("empty.yaml", "{properties: {}, layers: []}")
        world = World.from_file(empty, LocalTransport(params), loader=self.loader)
        world.spawn_model(path, "robot", "", Pose())
        return world

    def refusal(self, name: str = "world.yaml") -> str:
        """The error of loading a world, without the folder's name."""
        with pytest.raises(FlatlandError) as caught:
            self.load(name).close()
        return self.without_folder(str(caught.value))

    def without_folder(self, text: str) -> str:
        """A string with file names in place of paths in the folder."""
        return re.sub(rf"{re.escape(str(self.folder))}/", "", text)


@pytest.fixture
def files(tmp_path: Path) -> Files:
    """An empty folder."""
    return Files(tmp_path)


@pytest.fixture
def good_files(files: Files) -> Files:
    """A folder with a world that loads."""
    files.write_good_ones()
    return files
