"""Many environments with several robots: equal to single ones, to the bit."""

import numpy as np
import pytest
from environments import assert_same

from flatland2d import UsageError
from flatland_gym.multi_robot_env import MultiRobotEnv
from flatland_gym.multi_robot_vector_env import MultiRobotVectorEnv


class Singles:
    """The arrays of a vector environment, made of `MultiRobotEnv`, which are reset at once."""

    def __init__(self, count, **arguments):
        self.envs = [MultiRobotEnv(**arguments) for _ in range(count)]

    def reset(self, seed):
        for k, env in enumerate(self.envs):
            env.current = env.reset(seed=seed + k)
        return self.rows(0)

    def step(self, actions):
        """The step's results, and the observations after resets."""
        results = []
        for env, rows in zip(self.envs, actions):
            of_agent = dict(zip(env.possible_agents, rows))
            result = env.step({agent: of_agent[agent] for agent in env.agents})
            results.append((*result, list(env.agents), env.state()))
            env.current = result[0], result[4]
        final = self.rows(0)
        ends = [
            np.array(
                [[r[n].get(a, 0) for a in e.possible_agents] for e, r in zip(self.envs, results)]
            )
            for n in (1, 2, 3)
        ]
        for env in self.envs:
            if not env.agents:
                env.current = env.reset()
        return final, ends, self.rows(0), self.rows(1, "distance")

    def rows(self, part, key=None):
        """The observations (part 0) or the values of infos (part 1) of the present results."""
        rows = []
        for env in self.envs:
            size = env.observation_space("robot_0").shape
            for agent in env.possible_agents:
                value = env.current[part].get(agent)
                if key is not None:
                    value = 0.0 if value is None else value[key]
                rows.append(np.zeros(size, np.float32) if value is None else value)
        return np.array(rows).reshape(len(self.envs), len(env.possible_agents), *np.shape(rows[0]))

    def states(self):
        return np.array([env.state() for env in self.envs])

    def close(self):
        for env in self.envs:
            env.close()


@pytest.mark.parametrize(
    "arguments",
    [
        {"world": "empty_room", "robots": 2, "threads": 2},
        {"world": "discs", "robots": 8, "beams": 16, "frame_skip": 3},
        {"world": "empty_room", "robots": 3, "at_goal": "stay", "goal_radius": 1.5},
        {"world": "corridor", "robots": 3, "shared_rewards": 0.4, "lidar_noise": 0.02},
        {"world": "doors", "robots": 3, "obstacles": (0, 3), "collision_ends": False},
    ],
    ids=lambda arguments: arguments["world"],
)
def test_environments_equal_single_ones_to_the_bit(arguments):
    arguments = {"time_limit": 4.0, "goal_distance": (1.0, 3.0), **arguments}
    threads = arguments.pop("threads", 1)
    count = 5
    envs = MultiRobotVectorEnv(count, threads=threads, autoreset_mode="SameStep", **arguments)
    singles = Singles(count, **arguments)
    observations, infos = envs.reset(seed=7)
    assert_same(observations, singles.reset(7))
    assert infos["present"].all()
    rng = np.random.default_rng(1)
    ended = gone = 0
    for _ in range(120):
        actions = rng.uniform(-0.2, 1.0, envs.action_space.shape).astype(np.float32)
        present = infos["present"]
        observations, *ends, infos = envs.step(np.where(present[..., None], actions, 0))
        final, expected, after, distances = singles.step(actions)
        assert_same(observations, after)
        for value, single in zip(ends, expected):
            assert_same(value, single.astype(value.dtype))
        assert_same(infos["distance"], distances)
        assert_same(envs.state(), singles.states())
        for k in np.flatnonzero(infos.get("_final_obs", np.zeros(count, bool))):
            assert_same(infos["final_obs"][k], final[k])
            ended += 1
        gone += (~infos["present"]).sum()
    assert ended > 3
    assert gone > 10 or not arguments.get("collision_ends", True)


def test_worlds_without_batches_give_the_same(monkeypatch):
    arguments = {"world": "discs", "robots": 3, "time_limit": 2.0, "at_goal": "stay", "beams": 8}
    runs = []
    for threads in (1, 2):
        if threads == 2:
            monkeypatch.setattr("flatland_gym.fleet.BatchFleet", refuse)
        envs = MultiRobotVectorEnv(4, threads=threads, **arguments)
        run = [envs.reset(seed=2)]
        for step in range(60):
            run.append(envs.step(np.full(envs.action_space.shape, 0.3 + 0.01 * step)))
        runs.append(run)
    assert_same(*runs)


def refuse(*_):
    from flatland2d import PluginError

    raise PluginError("no batches")


def test_an_environment_does_not_depend_on_the_others():
    few, many = (MultiRobotVectorEnv(n, 3, world="discs", time_limit=2.0) for n in (1, 6))
    a, b = few.reset(seed=4)[0], many.reset(seed=4)[0]
    for _ in range(60):
        assert_same(a[0], b[0])
        actions = np.full(many.action_space.shape, 0.4)
        a, b = few.step(actions[:1])[0], many.step(actions)[0]


def test_resets_by_mask():
    envs = MultiRobotVectorEnv(
        3, 2, world="empty_room", time_limit=0.2, autoreset_mode="Disabled", flatten=False
    )
    observations, _ = envs.reset(seed=1)
    assert envs.observation_space.contains(observations)
    zeros = np.zeros(envs.action_space.shape, np.float32)
    assert envs.action_space.contains(zeros)
    for _ in range(4):
        *_, truncated, infos = envs.step(zeros)
    assert truncated.all()
    assert not infos["present"].any()
    with pytest.raises(UsageError, match="episodes have ended"):
        envs.step(zeros)
    mask = np.array([True, False, True])
    start = {"robot_1": [1, 1, 0]}
    _, infos = envs.reset(options={"reset_mask": mask, "start": start})
    assert infos["present"].tolist() == [[True] * 2, [False] * 2, [True] * 2]
    assert infos["pose"][mask, 1].tolist() == [[1, 1, 0]] * 2


def test_wrong_arguments():
    for arguments, message in (
        ({"robots": 1}, "expected robots to be a whole number of 2 or more, found 1"),
        ({"at_goal": "vanish"}, "expected at_goal to be one of 'leave', 'stay', found 'vanish'"),
        ({"shared_rewards": 1.5}, "expected shared_rewards to be a number from 0 to 1, found 1.5"),
        ({"shared_rewards": True}, "found True"),
        ({"shared_rewards": float("nan")}, "found nan"),
        ({"world": ("discs", "doors")}, "expected one world"),
    ):
        for make in (MultiRobotEnv, MultiRobotVectorEnv):
            with pytest.raises(UsageError, match=message):
                make(**arguments)
    envs = MultiRobotVectorEnv(2, 3, world="empty_room")
    with pytest.raises(UsageError, match="expected reset before step"):
        envs.step(np.zeros((2, 3, 2)))
    envs.reset(seed=1)
    with pytest.raises(UsageError, match=r"actions of shape \(2, 3, 2\), found \(2, 2\)"):
        envs.step(np.zeros((2, 2)))


def test_pictures_show_a_robot_that_is_there():
    envs = MultiRobotVectorEnv(2, 2, world="discs", render_mode="rgb_array", render_envs=1)
    envs.reset(seed=1)
    pictures = envs.render()
    assert pictures[0].shape == (480, 480, 3)
    assert pictures[0].any()
    assert not pictures[1].any()
