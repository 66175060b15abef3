"""Shared by the tests of the documentation: its examples in a folder, and simulated time.

The examples are in `examples/`, copied from the documentation's pages. Defects there are
mended: indentation, and the commas that are missing in covariance matrices.
"""

import shutil
from pathlib import Path
from typing import Any, Set, Tuple

import pytest

from flatland_server import ModelConfig, Pose, YamlReader
from flatland_server.models.collision_filter_registry import AnyLayer
from flatland_server.testing import Harness

EXAMPLES = Path(__file__).parent / "examples"
DISC = "footprints: [{type: circle, radius: 0.2, density: 1}]"
IN_FRONT_OF_A_WALL = """
properties: {{}}
layers: [{{name: [layer_1, layer_2, layer_3], map: wall.yaml}}]
models: [{{name: robot, model: robot.model.yaml, namespace: "{namespace}", pose: {pose}}}]
"""


class RobotSimulation(Harness):
    """A world with the model "robot", 5 ms a step."""

    def throw(self, speed: float, *bodies: str) -> "RobotSimulation":
        """Gives bodies of the robot a velocity along the x axis."""
        for name in bodies:
            self.world.get_model("robot").bodies[name].physics_body.velocity = (speed, 0.0, 0.0)
        return self

    def pose(self, body: str = "base") -> Pose:
        """The pose of a body of the robot."""
        return self.world.get_model("robot").bodies[body].pose

    @property
    def frames(self) -> Set[Tuple[str, str]]:
        """The transforms published so far, as pairs of parent and child."""
        return {(each.parent, each.child) for each in self.transport.transforms.values()}


class Documented:
    """A folder with the documentation's examples, and the files that they name."""

    def __init__(self, files: Any) -> None:
        shutil.copytree(EXAMPLES, files.folder, dirs_exist_ok=True)
        self.files = files
        self.folder: Path = files.folder
        files.draw_map("conestogo_office.png")
        files.draw_map("map.png")
        files.write(
            "wall.yaml", "{type: line_segments, data: wall.dat, scale: 1, origin: [0, 0, 0]}"
        )
        files.write("wall.dat", "1 -9 1 9")
        files.write("person.model.yaml", f"bodies: [{{name: body, {DISC}}}]")
        for name in ("layer_2.yaml", "person.model.yaml"):
            files.edit("world.yaml", f"/absolute/path/{name}", str(self.folder / name))

    def text(self, name: str) -> str:
        """An example."""
        return (self.folder / name).read_text(encoding="utf-8")

    def page(self, name: str) -> str:
        """The `plugins` of a plugin's page."""
        return self.text(f"plugins/{name}.yaml")

    @property
    def tricycle(self) -> str:
        """The tutorial's cleaner up to its plugins."""
        return self.text("cleaner.model.yaml").partition("plugins:")[0]

    @staticmethod
    def discs(*names: str) -> str:
        """Bodies: discs of 20 cm, 1 m apart along the y axis."""
        lines = [
            f"  - {{name: {name}, pose: [0, {y}, 0], {DISC}}}\n" for y, name in enumerate(names)
        ]
        return "bodies:\n" + "".join(lines)

    def load(self, name: str) -> RobotSimulation:
        """The world of a file."""
        return RobotSimulation(self.files.load(name))

    def spawn(self, name: str) -> RobotSimulation:
        """An empty world with the robot of a model file."""
        return RobotSimulation(self.files.spawn(self.text(name)))

    def robot(
        self, plugins: str, model: str = "", *, namespace: str = "", pose: str = "[0, 0, 0]"
    ) -> RobotSimulation:
        """A world with a robot in it, and a wall across the x axis at 1 m.

        Args:
            plugins: a page's, or the entry of one.
            model: the file up to the plugins; by default a disc named "base".
            namespace: the robot's namespace.
            pose: the robot's pose.
        """
        self._write(plugins, model)
        self.files.write("walled.yaml", IN_FRONT_OF_A_WALL.format(namespace=namespace, pose=pose))
        return self.load("walled.yaml")

    def reader(self, plugins: str, model: str = "") -> YamlReader:
        """The entry of the first plugin of such a robot."""
        self._write(plugins, model)
        return self.model("robot.model.yaml").plugins[0].reader

    def model(self, name: str) -> ModelConfig:
        """The configuration in a model file."""
        return ModelConfig.from_file(self.folder / name, AnyLayer())

    def _write(self, plugins: str, model: str) -> None:
        if "plugins:" not in plugins:
            plugins = f"plugins:\n  - {{{plugins}}}\n"
        self.files.write("robot.model.yaml", (model or self.discs("base")) + plugins)


@pytest.fixture
def documented(files: Any) -> Documented:
    return Documented(files)
