"""The example plugins, in worlds without ROS: simulated time is stepped, never waited for."""

import logging
from pathlib import Path
from typing import Any, Dict, List

import pytest

from flatland_server import FlatlandError, Pose, SimulationManager, Timekeeper, World

CONVEYOR = Path(__file__).resolve().parents[1] / "worlds" / "conveyor" / "world.yaml"

DISC = "{name: base, footprints: [{type: circle, radius: 0.2, density: 10}]}"


class Simulation(SimulationManager):
    """A world, and what it publishes."""

    def __init__(self, path: Path) -> None:
        super().__init__(World.from_file(path), Timekeeper(step_size=0.005))

    def pass_time(self, seconds: float) -> None:
        """Lets simulated time pass."""
        for _ in range(round(seconds / self.timekeeper.step_size)):
            self.step()

    def last(self, topic: str) -> Any:
        """The newest message of a topic."""
        return self.world.transport.last(topic)

    def models(self) -> Dict[str, Pose]:
        """Where which models are."""
        return {name: model.pose for name, model in self.world.models.items()}


@pytest.fixture
def simulate(tmp_path):
    """Makes a world of a wall at x = 3 m and a robot, a disc of 0.2 m, with a plugin."""

    def make(plugin: str, pose: str = "[0, 0, 0]") -> Simulation:
        (tmp_path / "wall.dat").write_text("3 -5 3 5")
        (tmp_path / "wall.yaml").write_text(
            "{type: line_segments, data: wall.dat, scale: 1, origin: [0, 0, 0]}"
        )
        (tmp_path / "post.yaml").write_text(f"bodies: [{DISC}]")
        (tmp_path / "robot.yaml").write_text(f"bodies: [{DISC}]\nplugins: [{{{plugin}}}]")
        world = tmp_path / "world.yaml"
        world.write_text(
            "properties: {}\n"
            "layers: [{name: wall, map: wall.yaml}]\n"
            "models:\n"
            f"  - {{name: robot, namespace: r1, pose: {pose}, model: robot.yaml}}\n"
            "  - {name: post, pose: [-3, 0, 0], model: post.yaml}\n"
        )
        return Simulation(world)

    return make


def test_const_velocity_is_in_the_worlds_frame(simulate):
    simulation = simulate(
        "type: ConstVelocity, name: a, body: base, vel_x: 0.2, vel_y: -0.3, omega: 0.4",
        pose="[1, 2, 1.5]",
    )

    simulation.pass_time(2.0)

    assert simulation.models()["robot"] == pytest.approx((1.4, 1.4, 2.3), abs=1e-4)


def test_const_velocity_does_not_care_who_stops_its_body(simulate):
    simulation = simulate(
        "type: ConstVelocity, name: a, body: base, vel_x: 0.5, vel_y: 0, omega: 0"
    )

    simulation.pass_time(1.0)
    simulation.world.models["robot"].base.physics_body.halt()
    simulation.pass_time(1.0)

    assert simulation.models()["robot"] == pytest.approx((1.0, 0.0, 0.0), abs=1e-4)


def test_const_velocity_names_what_is_wrong_with_its_configuration(simulate, tmp_path):
    with pytest.raises(FlatlandError) as refusal:
        simulate("type: ConstVelocity, name: a, body: bass, vel_x: fast, vel_y: 0, omega: 0, o: 1")

    assert str(refusal.value).replace(f"{tmp_path}/", "").splitlines() == [
        'robot.yaml:2: plugins[0].body: the model has no body "bass" (did you mean "base"?); '
        "it has: base",
        'robot.yaml:2: plugins[0].vel_x: expected a number, found "fast"',
        'robot.yaml:2: plugins[0] "a": unknown key "o"',
    ]


def test_simple_says_hello_once(simulate, caplog):
    caplog.set_level(logging.INFO)
    simulation = simulate("type: Simple, name: a")

    simulation.pass_time(1.0)

    assert [record.getMessage() for record in caplog.records] == ["Hello world"]


def test_contact_counter_counts_contacts_as_they_begin(simulate, caplog):
    caplog.set_level(logging.INFO)
    simulation = simulate("type: ContactCounter, name: a, update_rate: inf")
    free, at_wall, at_post = Pose(0.0, 0.0), Pose(2.81, 0.0), Pose(-2.61, 0.0)

    totals: List[int] = []
    for pose in (free, at_wall, free, at_post, free, at_wall):
        simulation.world.move_model("robot", pose)
        simulation.pass_time(0.5)  # a contact that lasts is one contact
        totals.append(simulation.last("/r1/contacts").data)
    simulation.world.delete_model("robot")

    assert totals == [0, 1, 1, 2, 2, 3]
    assert caplog.messages == ["a: contacts by what was touched: {'wall': 2, 'post': 1}"]


def test_contact_counter_publishes_at_its_rate(simulate):
    simulation = simulate("type: ContactCounter, name: a, topic: touches, update_rate: 20")

    messages = []
    for _ in range(200):
        simulation.step()
        messages.append(simulation.last("/r1/touches"))

    assert len({id(message) for message in messages}) == 20  # in a second


def test_the_conveyor_counts_its_boxes():
    simulation = Simulation(CONVEYOR)

    simulation.pass_time(20.0)

    # A box comes every 2 s, the first one with the first step, and is 0.2 m long each way. It goes
    # at 0.5 m/s from -3 m to 3 m, and has come to the gate, 0.05 m each way, after 2.75 m.
    age = [20.0 - 0.005 - 2.0 * i for i in range(10)]
    there = {f"box_{i}": (-3.0 + 0.5 * age[i], 0.0, 0.0) for i in range(10) if age[i] < 12.0}
    models = simulation.models()
    assert models.pop("gate") == (0.0, 0.0, 0.0)
    assert models.keys() == there.keys()
    for name, pose in models.items():
        assert pose == pytest.approx(there[name], abs=1e-3)
    assert simulation.last("/box/count").data == len(there)
    assert simulation.last("/gate/contacts").data == len([a for a in age if a > 5.5])


def test_a_feeder_tells_only_what_is_new():
    simulation = Simulation(CONVEYOR)

    messages = []
    for _ in range(600):
        simulation.step()
        messages.append(simulation.last("/box/count"))

    # The second of its boxes came after 2 of the 3 s.
    assert [message.data for message in {id(m): m for m in messages}.values()] == [1, 2]


def test_boxes_may_be_taken_from_the_conveyor():
    simulation = Simulation(CONVEYOR)
    simulation.pass_time(5.0)

    simulation.world.delete_model("box_1")
    simulation.pass_time(10.0)

    # Of the eight that have come, box_0 has left, and box_1 was taken.
    assert simulation.last("/box/count").data == 6
    assert simulation.world.plugin_failures == []


def test_a_feeder_that_would_spawn_outside_of_its_area_is_refused(tmp_path):
    (tmp_path / "box.yaml").write_text(f"bodies: [{DISC}]")
    world = tmp_path / "world.yaml"
    world.write_text(
        "properties: {}\nlayers: []\nplugins:\n"
        "  - {type: Feeder, name: box, model: box.yaml, pose: [5, 0, 0], area: [-4, -1, 4, 1]}\n"
    )

    with pytest.raises(FlatlandError) as refusal:
        World.from_file(world)

    assert str(refusal.value) == (
        f"{world}:4: plugins[0].area: expected [x_min, y_min, x_max, y_max] around the pose"
    )
