"""A Tween triggered by a BoolSensor's topic: an automatic door, without ROS."""

import pytest
import yaml

from flatland2d import PluginError, Simulation, SimulationBatch

WORLD = yaml.safe_load("""
properties: {}
layers: []
models:
- name: door
  namespace: d
  model:
    bodies:
    - {name: panel, type: kinematic, footprints: []}
    - {name: sensor, type: static,
       footprints: [{type: circle, radius: 1, density: 1, sensor: true}]}
    plugins:
    - {type: BoolSensor, name: s, body: sensor, topic: open, update_rate: 10}
    - {type: Tween, name: t, body: panel, mode: trigger, trigger_topic: open, delta: [0, 2, 0],
       duration: 0.5}
- name: robot
  pose: [-3, 0, 0]
  model:
    bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]
    plugins:
    - {type: DiffDrive, name: drive, body: base}
    - {type: Laser, name: laser, body: base, range: 5, angle: {min: 0, max: 1, increment: 0.5}}
""")


def opening(simulation):
    return round(simulation.models["door"].pose.y, 3)


def test_the_door_opens_for_a_robot_and_closes_behind_it():
    with Simulation(WORLD) as simulation:
        simulation.step(200)
        assert opening(simulation) == 0.0
        simulation.move("robot", (0.5, 0, 0))
        simulation.step(200)
        assert opening(simulation) == 2.0
        simulation.move("robot", (3, 0, 0))
        simulation.step(200)
        assert opening(simulation) == 0.0


def test_reading_a_message_does_not_move_the_door():
    with Simulation(WORLD) as simulation:
        simulation.move("robot", (0.5, 0, 0))
        simulation.step(1)  # the sensor is due at multiples of 0.1 s
        expected = simulation.save_state()
        simulation.last("/d/open")
        simulation.step(5)
        with Simulation(WORLD) as other:
            other.load_state(expected)
            other.step(5)
            assert opening(simulation) == opening(other)


def test_a_saved_state_goes_on_with_the_same_bits():
    with Simulation(WORLD) as simulation:
        simulation.move("robot", (0.5, 0, 0))
        simulation.step(30)
        state = simulation.save_state()
        simulation.step(40)
        expected = simulation.poses.tobytes()
        simulation.load_state(state)
        simulation.step(40)
        assert simulation.poses.tobytes() == expected


def test_a_batch_refuses_plugins_that_message_each_other():
    with pytest.raises(PluginError, match=r"acts on what another one publishes, on /d/open"):
        SimulationBatch(WORLD, 2)
