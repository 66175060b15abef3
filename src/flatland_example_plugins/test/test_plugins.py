"""The example plugins, in worlds without ROS: simulated time is stepped, never waited for."""

import logging
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict, List

import pytest

from flatland_server import Pose, World
from flatland_server.testing import Harness, WorldFiles, check_plugin, refusal

PACKAGE = Path(__file__).resolve().parents[1]
CONVEYOR = PACKAGE / "worlds" / "conveyor" / "world.yaml"
DECLARED = [
    element.get("name")
    for element in ElementTree.parse(PACKAGE / "flatland_plugins.xml").iter("class")
]

BOX = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]"
ENTRIES = {
    "ConstVelocity": "type: ConstVelocity, name: a, body: base, vel_x: 0.2, vel_y: 0, omega: 1",
    "ContactCounter": "type: ContactCounter, name: a, topic: contacts, update_rate: 10",
    "Feeder": "type: Feeder, name: a, model: box.yaml, pose: [2, 0, 0], area: [-4, -1, 4, 1], "
    "spawn_rate: 1, topic: a/count",
    "Simple": "type: Simple, name: a",
}
"""An entry of each plugin, with all its keys."""


@pytest.mark.parametrize("name", DECLARED)
def test_it_keeps_the_contract_of_plugins(name):
    check_plugin(ENTRIES[name], files={"box.yaml": BOX})


@pytest.fixture
def simulate(tmp_path):
    """Makes a world of a wall at x = 3 m, a post at x = -3 m, and a robot with a plugin."""

    def make(plugin: str, pose: str = "[0, 0, 0]") -> Harness:
        files = WorldFiles(tmp_path)
        post = {"post": f"model: {files.model('post')}, pose: [-3, 0, 0]"}
        return files.robot(plugin, namespace="r1", pose=pose, walls=["3 -5 3 5"], others=post)

    return make


@pytest.fixture
def conveyor() -> Harness:
    return Harness(World.from_file(CONVEYOR))


def poses(simulation: Harness) -> Dict[str, Pose]:
    """The poses of the models, by name."""
    return {name: model.pose for name, model in simulation.world.models.items()}


def test_const_velocity_is_in_the_worlds_frame(simulate):
    simulation = simulate(
        "type: ConstVelocity, name: a, body: base, vel_x: 0.2, vel_y: -0.3, omega: 0.4",
        pose="[1, 2, 1.5]",
    )

    simulation.run(2.0)

    assert poses(simulation)["robot"] == pytest.approx((1.4, 1.4, 2.3), abs=1e-4)


def test_const_velocity_drives_on_after_a_halt(simulate):
    simulation = simulate(
        "type: ConstVelocity, name: a, body: base, vel_x: 0.5, vel_y: 0, omega: 0"
    )

    simulation.run(1.0)
    simulation.world.models["robot"].base.physics_body.halt()
    simulation.run(1.0)

    assert poses(simulation)["robot"] == pytest.approx((1.0, 0.0, 0.0), abs=1e-4)


def test_const_velocity_reports_each_wrong_key():
    message = refusal("type: ConstVelocity, name: a, body: bass, vel_x: fast, omega: 0, o: 1")

    assert message.splitlines() == [
        'robot.model.yaml:5: plugins[0].body: the model has no body "bass" (did you mean "base"?); '
        "it has: base",
        'robot.model.yaml:5: plugins[0].vel_x: expected a number, found "fast"',
        'robot.model.yaml:5: plugins[0] "a": the required key "vel_y" is missing',
        'robot.model.yaml:5: plugins[0] "a": unknown key "o"',
    ]


def test_simple_says_hello_once(simulate, caplog):
    caplog.set_level(logging.INFO)
    simulation = simulate("type: Simple, name: a")

    simulation.run(1.0)

    assert [record.getMessage() for record in caplog.records] == ["Hello world"]


def test_contact_counter_counts_contacts_as_they_begin(simulate, caplog):
    caplog.set_level(logging.INFO)
    simulation = simulate("type: ContactCounter, name: a, update_rate: inf")
    free, at_wall, at_post = Pose(0.0, 0.0), Pose(2.81, 0.0), Pose(-2.61, 0.0)

    totals: List[int] = []
    for pose in (free, at_wall, free, at_post, free, at_wall):
        simulation.world.move_model("robot", pose)
        simulation.run(0.5)  # a contact that lasts is one contact
        totals.append(simulation.last("/r1/contacts").data)
    simulation.world.delete_model("robot")

    assert totals == [0, 1, 1, 2, 2, 3]
    assert caplog.messages == ["a: contacts by what was touched: {'walls': 2, 'post': 1}"]


def test_the_conveyor_counts_its_boxes(conveyor):
    conveyor.run(20.0)

    # A box comes every 2 s, the first one with the first step, and is 0.2 m long each way. It goes
    # at 0.5 m/s from -3 m to 3 m, and has come to the gate, 0.05 m each way, after 2.75 m.
    age = [20.0 - 0.005 - 2.0 * i for i in range(10)]
    there = {f"box_{i}": (-3.0 + 0.5 * age[i], 0.0, 0.0) for i in range(10) if age[i] < 12.0}
    models = poses(conveyor)
    assert models.pop("gate") == (0.0, 0.0, 0.0)
    assert models.keys() == there.keys()
    for name, pose in models.items():
        assert pose == pytest.approx(there[name], abs=1e-3)
    assert conveyor.last("/box/count").data == len(there)
    assert conveyor.last("/gate/contacts").data == len([a for a in age if a > 5.5])


def test_a_feeder_tells_only_what_is_new(conveyor):
    messages = conveyor.record("/box/count", 3.0)

    # The second of its boxes came after 2 s.
    assert [message.data for message in messages] == [1, 2]


def test_boxes_may_be_taken_from_the_conveyor(conveyor):
    conveyor.run(5.0)

    conveyor.world.delete_model("box_1")
    conveyor.run(10.0)

    # Of the eight that have come, box_0 has left, and box_1 was taken.
    assert conveyor.last("/box/count").data == 6


def test_a_feeder_with_a_pose_outside_its_area_is_refused():
    files = WorldFiles()
    files.write("box.yaml", BOX)

    message = files.refusal(
        "properties: {}\nlayers: []\nplugins:\n"
        "  - {type: Feeder, name: box, model: box.yaml, pose: [5, 0, 0], area: [-4, -1, 4, 1]}\n"
    )

    assert message == (
        "world.yaml:4: plugins[0].area: expected [x_min, y_min, x_max, y_max] around the pose"
    )
