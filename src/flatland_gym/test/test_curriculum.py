"""Options of resets, for one episode and for all; what rewards see of other models."""

import numpy as np
import pytest
from environments import assert_same, make, make_vector

from flatland2d import UsageError

pytestmark = pytest.mark.slow

WORLDS = {"world": ("discs", "empty_room"), "obstacles": (0, 4), "robot_scales": (0.8, 1.2)}


def columns(env, index=0):
    """The number of columns in play."""
    simulation = env.navigation.simulation(index)
    poses = dict(zip(simulation.models, simulation.poses.tolist()))
    return sum(n.startswith("obstacle_") and pose[0] < 1000 for n, pose in poses.items())


def test_options_take_the_place_of_arguments():
    env = make(**WORLDS)
    for _ in range(4):
        options = {"world": "empty_room", "goal_distance": (1, 1.2), "obstacles": 3}
        _, info = env.reset(seed=None, options={**options, "robot_scales": [1.2]})
        assert 1 <= info["distance"] <= 1.2
        assert columns(env) == 3
        simulation = env.navigation.simulation(0)
        assert "disc_1" not in simulation.models
        [fixture] = simulation.models["robot"].model.base.config.footprints
        assert fixture.shape.radius == pytest.approx(1.2 * 0.2)


def test_an_attribute_holds_for_all_resets_also_automatic_ones():
    env = make_vector(4, world="empty_room", time_limit=0.1, autoreset_mode="SameStep")
    env.reset(seed=1)
    for least, options in ((2, {"goal_distance": (2, 2.1)}), (5, {"goal_distance": (5, 5.1)})):
        env.unwrapped.reset_options = options
        for _ in range(2):
            *_, infos = env.step(np.zeros((4, 2)))
        assert infos["final_info"]["_distance"].all()
        assert ((least <= infos["distance"]) & (infos["distance"] <= least + 0.1)).all()
    _, infos = env.reset(options={"goal_distance": (1, 1.1)})
    assert (infos["distance"] <= 1.1).all()
    env.unwrapped.reset_options = {}
    assert env.reset(seed=3)[1]["distance"].max() > 1.1


def test_the_margin_can_grow_up_to_the_argument():
    env = make_vector(64, world="empty_room", margin=2.0)
    nearest = {}
    for margin in (0.0, 1.0, None):
        env.unwrapped.reset_options = {} if margin is None else {"margin": margin}
        _, infos = env.reset(seed=3)
        nearest[margin] = 5.0 - 0.2 - np.abs(infos["goal"]).max()
    assert 0.0 <= nearest[0.0] < 1.0 <= nearest[1.0] < 2.0 <= nearest[None]


def test_reset_options_act_alike_in_single_and_vector_envs():
    options = {"goal_distance": (1, 3), "obstacles": (1, 2), "world": ["discs"]}
    single, many = make(**WORLDS), make_vector(3, **WORLDS)
    single.reset_options = many.unwrapped.reset_options = options
    expected = single.reset(seed=7)
    observations, infos = many.reset(seed=5)
    assert_same(expected[0], observations[2])
    assert expected[1]["distance"] == infos["distance"][2]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"world": "office"}, "option world to be one of: discs, empty_room; found 'office'"),
        ({"world": []}, "one at least"),
        ({"robot_scales": [1.0]}, "option robot_scales to be one of: 0.8, 1.2; found 1.0"),
        ({"robot_scales": 1.2}, "robot_scales to be a sequence of numbers"),
        ({"obstacles": (0, 5)}, "obstacles of at most 4, the environment's largest number"),
        ({"goal_distance": (3, 1)}, "two increasing lengths above 0 m"),
        (
            {"margin": 1},
            "option margin of at most 0.1 m, as in the environment's arguments, found 1",
        ),
        ({"margin": -1}, "margin"),
        ({"lidar_noise": 1}, "unknown option 'lidar_noise'"),
        (3, "expected options as a dict, found 3"),
    ],
)
def test_wrong_options_change_nothing(options, message):
    env, other = make(**WORLDS), make(**WORLDS)
    env.reset(seed=1), other.reset(seed=1)
    env.reset_options = {"goal_distance": (1, 2)}
    with pytest.raises(UsageError, match=message):
        env.reset_options = options
    assert env.reset_options == {"goal_distance": (1, 2)}
    with pytest.raises(UsageError, match=message):
        env.reset(options=options)
    assert_same(env.reset(), other.reset(options={"goal_distance": (1, 2)}))


def test_rewards_see_the_other_models():
    seen = []

    def reward(step):
        seen.append((step.models.names, step.models.poses, step.models.velocities))
        return 0.0 * step.distance

    arguments = {"world": ("corridor", "empty_room"), "obstacles": 1, "reward": reward}
    many, single = make_vector(3, **arguments), make(**arguments)
    for env, action in ((many, np.zeros((3, 2))), (single, np.zeros(2))):
        env.reset(seed=2, options={"world": "corridor"})
        for _ in range(5):
            env.step(action)
    names, poses, velocities = seen[4]
    assert names == (*(f"person_{k}" for k in range(12)), "obstacle_1")
    for index in range(3):
        simulation = many.navigation.simulation(index)
        rows = [list(simulation.models).index(name) for name in names]
        assert np.array_equal(poses[index, :, :2], simulation.poses[rows, :2])
        # Some have turned by whole turns against the view's, where a float of 2 pi rounds.
        rounding = np.spacing(np.float32(2 * np.pi))
        assert np.allclose(poses[index, :, 2], simulation.poses[rows, 2], rtol=0.0, atol=rounding)
        assert np.array_equal(velocities[index], simulation.velocities[rows])
    assert np.hypot(*velocities[0, :6, :2].T).min() > 0
    assert np.array_equal(seen[-1][1][0], poses[0])
    single.reset(options={"world": "empty_room"})
    single.step(np.zeros(2))
    assert np.isnan(seen[-1][1][0, :12]).all()
    assert not np.isnan(seen[-1][1][0, 12]).any()
