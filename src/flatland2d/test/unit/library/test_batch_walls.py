"""Environments with walls of their own: a map for each."""

import numpy as np
import pytest
from library.parts import room

from flatland2d import Simulation, SimulationBatch, StateError, UsageError, Walls
from flatland_server.simulation.world_config import WorldConfig

WORLD = room({"segments": [[-9, -9, 9, -9]]}, {"segments": [[-9, 3, 9, 3]]})


def box(half):
    """The sides of a square around the origin, of which the robot meets one."""
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]], float)
    return np.hstack([corners[:-1], corners[1:]])


def drive(batch, steps, actions):
    return [batch.step(actions, 5) for _ in range(steps)]


def simulated(config, command, steps):
    with Simulation(config) as simulation:
        robot = simulation.models["robot"]
        for _ in range(steps):
            robot.command(*command)
            simulation.step(5)
        return robot.sensors["laser"].read(), simulation.poses[0], simulation.save_state()


@pytest.mark.parametrize("threads", [1, 2])
def test_an_environment_equals_a_simulation_with_its_walls(threads):
    halves, config = (1.0, 2.0, 4.0), WorldConfig.from_content(WORLD)
    maps = [Walls(box(half)) for half in halves]
    actions = np.array([[1.0, 0.3]] * 4)
    with SimulationBatch(WORLD, 4, threads=threads) as batch:
        drive(batch, 10, actions)  # near the walls of the world
        batch.reset(walls=dict(enumerate(maps)))
        found = drive(batch, 80, actions)[-1]
        for k, half in enumerate(halves):
            ranges, pose, _ = simulated(config.with_walls(box(half)), actions[k], 80)
            assert np.array_equal(found.ranges[k], ranges), half
            assert np.array_equal(found.poses[k], pose), half
        ranges, pose, _ = simulated(config, actions[3], 80)
        assert np.array_equal(found.ranges[3], ranges)
        batch.reset(walls={0: None, 1: maps[0]})  # back to the world's, and to another's
        found = drive(batch, 80, actions)[-1]
        assert np.array_equal(found.poses[0], pose)
        ranges, pose, _ = simulated(config.with_walls(box(1.0)), actions[1], 80)
        assert np.array_equal(found.poses[1], pose)
        assert np.array_equal(batch.view(1).world.layers[0].segments, box(1.0))
        assert len(batch.view(0).world.layers[0].segments) == 1


def test_a_state_has_its_walls():
    actions = np.array([[1.0, 0.3]] * 2)
    with SimulationBatch(WORLD, 2) as batch, SimulationBatch(WORLD, 2) as other:
        batch.reset(walls={1: Walls(box(1.0))})
        drive(batch, 40, actions)
        states = batch.save_states()
        expected = drive(batch, 40, actions)[-1]
        other.load_states(states)
        found = drive(other, 40, actions)[-1]
        assert np.array_equal(found.poses, expected.poses)
        assert np.array_equal(found.ranges, expected.ranges)
        with Simulation(WORLD) as simulation, pytest.raises(StateError, match="walls of its own"):
            simulation.load_state(states[1])
        before = other.observe()
        with pytest.raises(StateError):
            other.load_states([states[1], states[1][:-40] + b"0" * 40])
        assert np.array_equal(other.observe().ranges, before.ranges)


def test_wrong_walls_change_nothing():
    for wrong in ([[0, 0, 0, 0]], [[0, 0, np.inf, 1]], [[0, 0, 1]]):
        with pytest.raises(ValueError, match=r"wall|position|shape"):
            Walls(np.array(wrong))
    own = Walls(box(1.0))
    with SimulationBatch(WORLD, 2) as batch:
        before = batch.observe()
        for walls in ({2: own}, {-1: own}, {0: box(1.0)}, own):
            with pytest.raises(UsageError, match="expected"):
                batch.reset(walls=walls)
        with pytest.raises(UsageError, match="that are reset"):
            batch.reset(mask=[True, False], walls={1: own})
        assert np.array_equal(batch.observe().ranges, before.ranges)
    bare = {**WORLD, "layers": []}
    with SimulationBatch(bare, 1) as batch, pytest.raises(UsageError, match="no layer"):
        batch.reset(walls={0: own})
    with Simulation(WORLD) as simulation:
        simulation.move("robot", (0.0, 2.69, 0.0))  # at a wall
        simulation.step(10)
        state = simulation.save_state()
    with SimulationBatch(WORLD, 1, state=state) as batch:
        batch.step(np.zeros((1, 2)))
        with pytest.raises(UsageError, match=r"cannot be replaced: .* near walls"):
            batch.reset(walls={0: own})
