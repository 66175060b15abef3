"""Environments in which each episode has a map of its own."""

import numpy as np
import pytest
from environments import assert_same, make, make_vector

from flatland2d import DistanceGrid, UsageError
from flatland_gym import Rooms

pytestmark = pytest.mark.slow

MAPS = {"world": "empty_room", "maps": Rooms(boxes=10), "time_limit": 1.0}


def run(env, steps=40, count=None):
    """The results of a reset and of steps with random actions."""
    rng = np.random.default_rng(0)
    results = [env.reset(seed=7)]
    shape = (2,) if count is None else (count, 2)
    for _ in range(steps):
        results.append(env.step(rng.uniform(-1.0, 1.0, shape).astype(np.float32)))
    return results


def walls(number):
    return Rooms(boxes=10)(np.random.default_rng(number))


def test_each_episode_draws_a_map_and_has_its_walls():
    env = make(**MAPS, num_maps=3)
    numbers = set()
    for seed in range(20):
        _, info = env.reset(seed=seed)
        numbers.add(info["map"])
        shown = env.navigation.simulation(0).world.layers[0].segments
        assert np.array_equal(shown, walls(info["map"]))
    assert numbers == set(range(3))


def test_with_maps_vector_single_and_threaded_runs_are_equal():
    single = make(**MAPS, num_maps=3)
    single.reset(seed=7)
    many = make_vector(5, **MAPS, num_maps=3, threads=2)
    first, later = run(many, count=5), run(make_vector(5, **MAPS, num_maps=3), count=5)
    assert_same(first, later)
    observation, info = single.reset(seed=7)
    assert_same(first[0][0][0], observation)
    assert first[0][1]["map"][0] == info["map"]
    rng = np.random.default_rng(0)
    for result in first[1:20]:
        action = rng.uniform(-1.0, 1.0, (5, 2)).astype(np.float32)[0]
        observation, reward, *_ = single.step(action)
        assert_same(result[0][0], observation)
        assert result[1][0] == reward


def test_options_choose_the_map_of_a_curriculum():
    env = make(**MAPS)
    assert env.reset(seed=1, options={"map": 123_456})[1]["map"] == 123_456
    env.reset_options = {"map": range(40, 42)}
    assert {env.reset()[1]["map"] for _ in range(20)} == {40, 41}
    assert env.reset(options={"map": np.array(7)})[1]["map"] == 7
    assert env.reset(options={"map": range(10**15)})[1]["map"] >= 0
    for wrong in (-1, "a", [], [0.5], range(-1, 3), range(0), dict, 10**30, [2**63]):
        with pytest.raises(UsageError, match="option map"):
            env.reset(options={"map": wrong})
    plain = make(world="empty_room")
    with pytest.raises(UsageError, match="without maps"):
        plain.reset(options={"map": 1})


def test_a_saved_state_goes_on_with_its_map():
    env = make_vector(3, **MAPS, num_maps=50)
    env.reset(seed=1)
    states = env.save_states()
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1.0, 1.0, (15, 3, 2))
    expected = [env.step(each) for each in actions]
    other = make_vector(3, **MAPS, num_maps=50)
    other.reset(seed=9)
    other.load_states(states)
    assert_same([other.step(each)[:4] for each in actions], [each[:4] for each in expected])


def test_neighbours_behind_the_walls_of_a_map_are_hidden():
    corners = np.array([[-6, -6], [6, -6], [6, 6], [-6, 6], [-6, -6]], float)
    fence = np.hstack([corners[:-1], corners[1:]])
    cell = np.array([[1, -1, 1, 1], [1, 1, -1, 1], [-1, 1, -1, -1], [-1, -1, 1, -1]], float)
    seen = []
    for walls in (fence, np.concatenate([fence, cell + 3])):
        env = make(
            world="discs", obstacles=3, neighbors=20, neighbor_range=30, maps=lambda rng, w=walls: w
        )
        env.reset(seed=3, options={"map": 0})
        simulation, rows = env.navigation.simulation(0), env.navigation
        places = {n: m.pose for n, m in simulation.models.items() if n != "robot"}
        x, y, _ = rows.rows.poses[0]
        lines = [[x, y, place.x, place.y] for place in places.values() if place.x < 1000]
        hidden = rows._maps[0].lines.blocked(np.array(lines))
        observed = np.count_nonzero(
            env.navigation.observe()[0, -20 * 6 :].reshape(20, 6).any(axis=1)
        )
        seen.append((observed, len(lines), int(hidden.sum())))
    for observed, count, hidden in seen:
        assert observed == count - hidden
    assert seen[1][2] > 0


@pytest.mark.parametrize(
    "wrong",
    [
        *({"size": each} for each in (20, ("long", "wide"), (20, 20, 20), (20, float("nan")))),
        *({"boxes": each} for each in (1.5, True, -1)),
        *({"box": each} for each in (0.5, (2, 1), (1, 30))),
        *({"door": each} for each in (-1, 0.0)),
        {"room": 2.0},
    ],
    ids=str,
)
def test_wrong_sizes_of_rooms_are_told(wrong):
    with pytest.raises(UsageError, match=r"expected .* (sizes|six doors).*, found Rooms"):
        Rooms(**wrong)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"maps": 3}, "expected maps to be a function"),
        ({"maps": lambda rng: "walls"}, "maps: the walls of map 0"),
        ({"maps": lambda rng: [[0, 0, np.nan, 1]]}, "maps: the walls of map 0: .* finite"),
        ({"maps": lambda rng: np.empty((0, 4))}, "maps: expected walls of map 0, found none"),
        ({"maps": lambda rng: np.zeros((3, 5))}, "maps: the walls of map 0: .*shape"),
        ({"maps": Rooms(), "num_maps": 0}, "expected num_maps to be a whole number above 0"),
        ({"maps": Rooms(), "world": ["discs", "office"]}, "expected one world"),
    ],
)
def test_wrong_maps_are_told(arguments, message):
    with pytest.raises(UsageError, match=message):
        make(**{"world": "empty_room", "num_maps": 1, **arguments}).reset(seed=0)


def test_a_wrong_map_leaves_the_environment_as_it_was():
    made = []

    def fails_later(rng):
        made.append(1)
        return Rooms()(rng) if len(made) == 1 else None

    env = make(world="empty_room", maps=fails_later)
    env.reset(seed=0, options={"map": 0})
    before = env.navigation.rows.poses.copy()
    with pytest.raises(UsageError, match="maps: the walls of map 1: segments must be"):
        env.reset(options={"map": 1})
    assert np.array_equal(env.navigation.rows.poses, before)
    env.step(np.zeros(2))


@pytest.mark.parametrize("seed", range(8))
def test_rooms_are_connected_and_the_same_for_the_same_numbers(seed):
    rooms = Rooms(size=(24.0, 15.0), boxes=0)
    segments = rooms(np.random.default_rng(seed))
    assert np.array_equal(segments, rooms(np.random.default_rng(seed)))
    assert len(segments) > 8
    grid = DistanceGrid(segments, (-11.0, -6.5), 0.45)
    free = grid._distances >= 0.45 + 0.05  # where a robot that fits through doors can stand
    reached = grid.free_space(0.45)._reachable
    assert reached.sum() > 0.95 * free.sum()
