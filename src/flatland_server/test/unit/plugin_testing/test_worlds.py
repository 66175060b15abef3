"""flatland_server.testing: worlds of a few lines, simulated time and messages."""

import gc
import subprocess
import sys

import pytest
from plugin_testing.broken_beacons import Breaks

from flatland_server import FlatlandError, PluginDeclaration, PluginLoader
from flatland_server.testing import WorldFiles, load, refusal, robot

DRIVE = {"type": "DiffDrive", "name": "drive", "body": "base"}
LASER = "type: Laser, name: laser, body: base, range: 9, angle: {min: 0, max: 0, increment: 1}"


@pytest.mark.parametrize("plugin", [DRIVE, "type: DiffDrive, name: drive, body: base"])
def test_a_robot_obeys_commands_and_tells_where_it_is(plugin):
    simulation = robot(plugin, pose=(1.0, 2.0, 0.0))

    simulation.drive(0.5).run(2.0)

    assert simulation.model().pose == pytest.approx((2.0, 2.0, 0.0), abs=1e-3)
    truth = simulation.last("/odometry/ground_truth")
    assert truth.pose.pose.position.x == pytest.approx(2.0, abs=5e-3)
    assert simulation.timekeeper.seconds == pytest.approx(2.0)


@pytest.mark.parametrize("wall", ["3 -1 3 1", (3.0, -1.0, 3.0, 1.0)])
def test_a_robot_sees_walls_and_other_models(wall):
    files = WorldFiles()
    post = files.model("post", footprint="{type: circle, radius: 0.5, density: 1}")

    alone = files.robot(LASER, walls=[wall]).run().last("/scan")
    together = files.robot(LASER, walls=[wall], others={"post": f"model: {post}, pose: [2, 0, 0]"})

    assert alone.ranges == pytest.approx([3.0])
    assert together.run().last("/scan").ranges == pytest.approx([1.5])


def test_record_returns_only_new_messages():
    simulation = robot(f"{LASER}, update_rate: 40").run(0.5)

    scans = simulation.record("/scan", 0.5)

    assert [scan.header.stamp.to_nsec() for scan in scans] == [
        500_000_000 + 25_000_000 * i for i in range(20)
    ]


@pytest.mark.parametrize(
    "world",
    [
        {"properties": {}, "layers": [{"name": "floor"}]},
        "properties: {}\nlayers: [{name: floor}]",
        "  properties: {}\n  layers: [{name: floor}]",
    ],
)
def test_a_world_is_a_dict_or_yaml(world):
    assert [layer.name for layer in load(world).world.layers] == ["floor"]


def test_a_refusal_is_the_message_without_the_folder():
    message = refusal("type: Laser, name: laser, bdoy: base, range: 9, angle: {min: 0, max: 0}")

    assert message.splitlines()[-1] == (
        'robot.model.yaml:5: plugins[0] "laser": unknown key "bdoy" (did you mean "body"?)'
    )
    assert WorldFiles().refusal("properties: {}") == (
        'world.yaml:1: the required key "layers" is missing'
    )


def test_refusal_fails_if_nothing_is_refused():
    with pytest.raises(AssertionError, match="expected a FlatlandError, but the world was loaded"):
        refusal(DRIVE)


def test_a_plugin_that_fails_ends_the_test_unless_it_may():
    simulation = WorldFiles(loader=PluginLoader([PluginDeclaration.of(Breaks)])).robot(
        "type: Breaks, name: a"
    )

    with pytest.raises(AssertionError, match='"robot/a" failed in before_physics_step: ValueError'):
        simulation.run()
    simulation.allow_failures = True
    assert simulation.run().timekeeper.seconds == pytest.approx(0.01)


def test_the_files_live_as_long_as_the_simulation():
    simulation = robot(DRIVE)
    gc.collect()
    folder = simulation.files.folder

    simulation.world.spawn_model(
        folder / "robot.model.yaml", "other", "other", simulation.model().pose
    )
    assert (folder / "world.yaml").exists()
    del simulation
    gc.collect()

    assert not folder.exists()


def test_a_given_folder_stays(tmp_path):
    WorldFiles(tmp_path).robot(DRIVE)
    gc.collect()

    assert (tmp_path / "world.yaml").exists()


def test_a_model_that_is_not_there_is_named():
    with pytest.raises(FlatlandError, match=r'there is no model "robbot".*"robot"'):
        robot(DRIVE).model("robbot")


def test_neither_pytest_nor_rospy_is_needed():
    program = """
import sys
sys.modules["pytest"] = sys.modules["rospy"] = None
from flatland_server.testing import check_plugin, robot
print(robot().run(1.0).timekeeper.seconds)
"""
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)

    assert (result.stdout, result.stderr) == ("1.0\n", "")
