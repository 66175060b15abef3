"""The built-in plugins in a Python in which no package of ROS can be imported."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import List

import busy_town
import forklift
import pytest
from without_ros import run_without_ros

from flatland_server.testing import WorldFiles

HERE = Path(__file__).resolve().parent
DECLARED = ElementTree.parse(HERE.parents[1] / "flatland_plugins.xml").iter("class")
PROGRAM = """
from pathlib import Path
from test_without_ros import run_all
print("results:", *run_all(Path(sys.argv[1])))
assert not {name for name in sys.modules if name.endswith("_msgs") or name == "genpy"}
"""
OTHERS = """
  - {type: OmniDrive, name: omni, body: base, twist_sub: slide, odom_pub: slid}
  - {type: DummyModelPlugin, name: dummy, dummy_param_string: dummy_test,
     dummy_param_int: 123456, dummy_param_float: 123.456}
"""
CAR = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.2, density: 10}]}
  - {name: arm, footprints: [{type: circle, radius: 0.1, density: 1, layers: []}]}
joints:
  - {type: revolute, name: hinge,
     bodies: [{name: base, anchor: [0, 0]}, {name: arm, anchor: [0, 0]}]}
plugins:
  - {type: AckermannDrive, name: drive, body: base, wheelbase: 0.3, max_steer_angle: 0.5}
  - {type: JointMotor, name: motor, joint: hinge, max_torque: 1}
  - {type: JointStatePublisher, name: joints}
"""
WORLD = """
properties: {}
layers: []
models: [{name: robot, model: robot.yaml}]
plugins: [{type: DummyWorldPlugin, name: dummy, dummy_param_string: dummy_test,
           dummy_param_int: 123456, dummy_param_float: 123.456}]
"""


def run_all(folder: Path) -> List[str]:
    """Runs worlds with every built-in plugin; digests of their messages."""
    folder.mkdir()
    town = busy_town.Town(folder).digest(1.0)
    files = WorldFiles(folder)
    lift = forklift.forklift(files).drive(1.0, 0.5).run(1.0)
    files.write("robot.yaml", f"bodies: [{{name: base, footprints: []}}]\nplugins:{OTHERS}")
    omni = files.load(WORLD).drive(1.0, 0.5, left=0.5, topic="/slide").run(1.0)
    files.write("robot.yaml", CAR)
    car = files.load(WORLD).drive(1.0, 0.5).run(1.0)
    messages = [lift.last("/odometry/filtered"), lift.last("/twist"), omni.last("/slid")]
    messages += [car.last("/odometry/filtered"), car.last("/joint_states")]
    return [town, *(busy_town.content_of(each).hex() for each in messages if each is not None)]


def test_the_world_of_this_test_has_every_plugin():
    names = [element.get("name", "") for element in DECLARED]

    town = (busy_town.ROBOT, busy_town.DOOR, busy_town.WALKER, busy_town.WORLD)
    files = (*town, forklift.MODEL, OTHERS, CAR, WORLD)
    assert len(names) > 12
    assert [name for name in names if f"type: {name}" not in "".join(files)] == []


@pytest.mark.slow
def test_messages_are_those_made_with_ros(tmp_path):
    output = run_without_ros(PROGRAM, tmp_path / "without")

    results = output.rpartition("results: ")[2].split()
    assert len(results) == 5
    assert results == run_all(tmp_path / "with")
