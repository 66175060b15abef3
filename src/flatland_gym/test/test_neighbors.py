"""The nearest other models in observations: by hand, in environments, policies and sweeps."""

import math

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from environments import assert_same, make, make_vector

from flatland2d import UsageError
from flatland_gym import NavigationVectorEnv
from flatland_gym.observations import neighbor_rows
from flatland_gym.policy_node import PolicyNode
from flatland_gym.train import Network, Scale
from flatland_server._core import LinesOfSight

CORRIDOR = {"world": "corridor", "neighbors": 3, "beams": 8}


def rows(others, pose=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), count=1):
    found = neighbor_rows(
        np.array([pose]), np.array([velocity]), np.array([others], float), count, 10.0
    )
    return found.reshape(count, 6)


def test_an_approaching_model_has_its_time_to_collision():
    # 2 m ahead, 1.5 m apart, approached at 1.5 m/s: they touch after 1 s.
    [row] = rows([[2.0, 0.0, -1.0, 0.0, 0.5]], velocity=(0.5, 0.0, 0.0))

    np.testing.assert_allclose(row, [1 / 2.5, 1.0, 0.0, -1.5, 0.0, 1 / 2], atol=1e-6)


def test_bearing_and_velocity_are_in_the_robots_frame():
    [row] = rows([[1.0, 4.0, 0.0, 0.5, 1.0]], pose=(1.0, 1.0, np.pi / 2))

    np.testing.assert_allclose(row, [1 / 3, 1.0, 0.0, 0.5, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize(
    ("other", "danger"),
    [
        ([2.0, 0.0, 1.0, 0.0, 0.5], 0.0),  # goes away
        ([2.0, 0.6, -1.0, 0.0, 0.5], 0.0),  # passes at 0.6 m
        ([2.0, 0.3, -1.0, 0.0, 0.5], 1 / (1 + 2.0 - 0.4)),  # touches 0.4 m before it is abreast
        ([0.3, 0.0, 0.0, 0.0, 0.5], 1.0),  # touches
        ([2.0, 0.0, 0.0, 0.0, 0.5], 0.0),  # stands
    ],
)
def test_the_danger_follows_from_the_time_to_collision(other, danger):
    assert rows([other])[0, 5] == pytest.approx(danger, abs=1e-6)


def test_the_nearest_come_first_and_none_is_zeros():
    others = [[3.0, 0, 0, 0, 0.5], [np.nan] * 5, [5000.0, 0, 0, 0, 0.5], [2.0, 0, 0, 0, 0.5]]

    found = rows(others, count=3)

    np.testing.assert_allclose(found[:, 0], [1 / 2.5, 1 / 3.5, 0.0], atol=1e-6)
    assert not found[2].any()
    assert not rows(np.empty((0, 5)), count=2).any()


ROOM = [[-6, -6, 6, -6], [6, -6, 6, 6], [6, 6, -6, 6], [-6, 6, -6, -6]]
DISC = {"type": "circle", "radius": 0.2, "density": 1}
BOX = {"bodies": [{"name": "box", "type": "static", "footprints": [DISC]}]}
HIDDEN = {
    "properties": {},
    "layers": [{"name": "walls", "map": {"segments": [*ROOM, [1, -0.5, 1, 0.5]]}}],
    "models": [
        {"name": "robot", "model": "package://flatland_gym/worlds/robot.model.yaml"},
        *({"name": f"box_{x}_{y}", "pose": [x, y, 0], "model": BOX} for x, y in ((2, 0), (2, 3))),
    ],
}


def gaps_of(**arguments):
    """1 / (1 + gap) of the neighbours of a robot at the origin."""
    env = make(world=HIDDEN, neighbors=2, beams=8, **arguments)
    return env.reset(seed=1, options={"start": [0, 0, 0], "goal": [-2, 0]})[0][-12::6]


def test_walls_hide_models():
    seen, hidden = 1 / (1 + math.hypot(2, 3) - 0.4), 1 / (1 + 2 - 0.4)

    assert gaps_of() == pytest.approx([seen, 0.0])
    assert gaps_of(neighbors_behind_walls=True) == pytest.approx([hidden, seen])
    assert gaps_of(neighbors_behind_walls=True, neighbor_range=2.0) == pytest.approx([hidden, 0.0])
    for wrong in ({"neighbor_range": 0.0}, {"neighbor_noise": -1.0}):
        with pytest.raises(UsageError, match=f"expected {next(iter(wrong))} to be a number"):
            gaps_of(**wrong)


def test_lines_of_sight_end_at_walls():
    walls = LinesOfSight(np.array([[1.0, -1.0, 1.0, 1.0], [50.0, -1.0, 50.0, 1.0]]))
    hit = [[0, 0, 2, 0], [2, 0, 60, 0]]
    free = [[0, 0, 0.9, 0], [0, 0, 2, 3], [2, 0, 40, 0], [2, 2, 60, 2], [np.nan, 0, 2, 0]]
    lines = np.array([*hit, *free], float)

    assert walls.blocked(lines).tolist() == [True] * 2 + [False] * 5
    assert not LinesOfSight(np.empty((0, 4))).blocked(lines).any()


def test_neighbor_noise_has_its_deviation_and_varies_by_step():
    arguments = {**CORRIDOR, "neighbors": 12, "neighbor_range": 30.0}
    exact, noisy = (make_vector(60, **arguments, neighbor_noise=noise) for noise in (0.0, 0.2))
    values = [[], []]
    for env, kept in zip((exact, noisy), values):
        kept.append(env.reset(seed=3)[0])
        kept.append(env.step(np.zeros((60, 2), np.float32))[0])
    # Velocities are the fourth and fifth number; the order of the nearest differs with noise.
    for part in (3, 4):
        before, after = (
            [np.sort(each[:, 13 + part :: 6], axis=1) for each in kept] for kept in values
        )
        spread = after[0].std() ** 2 - before[0].std() ** 2
        assert spread == pytest.approx(0.2**2, rel=0.3)
        assert np.abs(after[1] - after[0]).mean() > 0.05


NOISY = {**CORRIDOR, "neighbor_noise": 0.1, "neighbor_range": 4.0}


@pytest.mark.parametrize("arguments", [CORRIDOR, NOISY], ids=["exact", "noisy"])
def test_neighbors_equal_in_single_and_vector_environments(arguments):
    single, many = make(**arguments), make_vector(2, **arguments)
    alone, together = single.reset(seed=4)[0], many.reset(seed=3)[0]
    assert alone.shape == (8 + 3 + 2 + 18,)
    for _ in range(3):
        assert_same(alone, together[1])
        assert alone in single.observation_space
        alone = single.step(np.array([0.5, 0.1], np.float32))[0]
        together = many.step(np.full((2, 2), [0.5, 0.1], np.float32))[0]
    assert alone[-18] > 0.0


def test_a_dict_has_them_as_a_part():
    env = make(**CORRIDOR, flatten=False)
    parts = env.reset(seed=4)[0]
    assert {name: part.shape for name, part in parts.items()} == {
        **{"ranges": (8,), "goal": (3,), "velocity": (2,), "neighbors": (3, 6)}
    }
    with pytest.raises(UsageError, match="neighbors to be a whole number of 0 to 10000, found -1"):
        make(**{**CORRIDOR, "neighbors": -1})


def test_a_policy_is_told_them(tmp_path):
    env = NavigationVectorEnv(1, **CORRIDOR)
    observation = env.reset(seed=4)[0]
    network = Network((31, 2), 1.0, np.random.default_rng(1))
    policy = env.navigation.policy(network.weights, network.biases)
    policy.save(tmp_path / "a.npz")
    policy = type(policy).load(tmp_path / "a.npz")
    assert policy.neighbors == 3
    navigation, state = env.navigation, env.navigation.rows
    poses, velocities = (each[0] for each in navigation._motions(np.array([0])))
    near = np.column_stack([poses[:, :2], velocities[:, :2], np.full(len(poses), 0.45)])
    place = state.ranges[0], state.poses[0], state.local_velocities[0], navigation.goals[0]

    assert policy.drive(*place, near) == pytest.approx(policy.act(observation)[0].tolist())
    assert len(policy.drive(*place, [])) == 2
    for wrong in (None, [1.0], [[1, 2, 3, 4, np.nan]]):
        with pytest.raises(UsageError, match="rows of x, y, vx, vy and radius"):
            policy.drive(*place, wrong)
    with pytest.raises(UsageError, match="found one with neighbors=3"):
        PolicyNode(policy, None, 0.3)


def test_a_scale_covers_all_rows_and_folds_into_a_layer():
    rng = np.random.default_rng(0)
    seen = (rng.normal(size=(600, 3)) * [1.0, 2.0, 3.0] + [5.0, 1.0, 0.0]).astype(np.float32)
    scale = Scale(3)
    for part in np.split(seen, [100, 250]):
        scale.take(scale.of(part))
    np.testing.assert_allclose(
        scale.of(seen), (seen - seen.mean(axis=0)) / seen.std(axis=0), atol=1e-4
    )
    weights, biases = rng.normal(size=(3, 2)).astype(np.float32), np.ones(2, np.float32)
    layer = scale.folded(weights, biases)
    np.testing.assert_allclose(
        seen @ layer[0] + layer[1], scale.of(seen) @ weights + biases, atol=1e-4
    )
