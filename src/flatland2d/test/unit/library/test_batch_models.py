"""Models that SimulationBatch.reset puts elsewhere: as Simulation.move does, bit for bit."""

import numpy as np
import pytest
from library.parts import DISC

from flatland2d import FlatlandError, Simulation, SimulationBatch, UsageError, world_content


def crowded_room():
    """A room with a robot, a box that can be pushed, a column, and two that stay.

    Of these, one is turned by more than a whole rotation, which Box2D loses in the first step.
    """
    content = world_content("test_room")
    [box] = [m for m in world_content("office")["models"] if m["name"] == "box_1"]
    place = {"name": "column", "type": "static", "pose": [0.1, 0.2, 0.3]}
    column = {"bodies": [{**place, "footprints": [DISC]}]}
    content["models"] += [{**box, "pose": [3, 1, 0]}, {"name": "column", "model": column}]
    content["models"][-1]["pose"] = [3, -1, 0]
    wedge = {"type": "polygon", "points": [[0, 0], [0.5, 0.1], [0.1, 0.4]], "density": 1}
    stays = {"bodies": [{"name": "wedge", "type": "static", "footprints": [wedge]}]}
    for name, pose in ("wedge", [2.2, 1.4, 0.5]), ("turned", [2.2, -1.4, 7.0]):
        content["models"].append({"name": name, "pose": pose, "model": stays})
    return content


def test_each_environment_is_a_simulation_with_its_models_there():
    content, rng = crowded_room(), np.random.default_rng(1)
    moved = ("column", "box_1")
    starts = np.column_stack([np.full(5, -2.0), rng.uniform(-1, 1, 5), np.zeros(5)])
    places = rng.uniform(-0.5, 0.5, (5, 2, 3))
    places[:, :, 0] += (1.2, 0.0)
    commands = np.column_stack([rng.uniform(0.5, 1.0, 5), rng.uniform(-0.2, 0.2, 5)])

    for threads in (1, 2):
        with SimulationBatch(content, 5, moved=moved, threads=threads) as batch:
            batch.step(commands, 50)
            rows = [batch.reset(poses=starts, model_poses=places)]
            rows += [batch.step(commands, 20) for _ in range(40)]
        for k in range(5):
            with Simulation(content, seed=k) as simulation:
                simulation.move("turtlebot", starts[k])
                for name, place in zip(moved, places[k]):
                    simulation.move(name, place)
                robot = simulation.models["turtlebot"]
                for step, row in enumerate(rows):
                    if step:
                        robot.command(*commands[k])
                        simulation.step(20)
                    assert row.ranges[k].tobytes() == robot.sensors["laser"].read().tobytes()
                    assert row.poses[k].tolist() == list(robot.pose)
    assert any(row.collided.any() for row in rows)


def test_only_environments_that_are_reset_move_their_models():
    content = crowded_room()
    places = np.zeros((2, 1, 3))
    places[:, 0] = [[1.0, 0, 0], [np.nan, 0, 0]]
    with SimulationBatch(content, 2, moved=["column"]) as batch:
        before = batch.observe()
        after = batch.reset(np.array([True, False]), model_poses=places)
    assert not np.array_equal(before.ranges[0], after.ranges[0])
    assert np.array_equal(before.ranges[1], after.ranges[1])


def test_wrong_calls_change_nothing():
    content = crowded_room()
    with pytest.raises(FlatlandError, match='there is no model "colum"'):
        SimulationBatch(content, 2, moved=["colum"])
    with pytest.raises(UsageError, match="expected moved as a list, found 'column'"):
        SimulationBatch(content, 2, moved="column")
    with pytest.raises(UsageError, match="expected other models as moved, found the robot"):
        SimulationBatch(content, 2, moved=["turtlebot"])
    with SimulationBatch(content, 2, moved=["column"]) as batch:
        batch.step(np.full((2, 2), 0.5), 20)
        before = batch.observe()
        for wrong in (np.zeros((2, 3)), np.full((2, 1, 3), np.nan), np.full((2, 1, 3), "a")):
            with pytest.raises(UsageError, match=r"expected (model_)?poses"):
                batch.reset(model_poses=wrong)
        after = batch.observe()
    assert all(a.tobytes() == b.tobytes() for a, b in zip(before, after))
