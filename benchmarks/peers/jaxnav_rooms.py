"""The room in JaxNav, of the package jaxmarl: robots in a map of squares, in one call of JAX."""

import os
from typing import Any

os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false"

import jax
import jax.numpy as jnp
import numpy as np
from jaxmarl.environments.jaxnav.jaxnav_env import JaxNav, State

import scenario
from scenario import Scenario

_RESOLUTION = 0.05
"""Between the points at which a beam is compared with the map [m]; the default."""
_SQUARE = 1.0
"""Side of a square of its map [m]: its default."""
_FAR = 1e6
_OUTLINE = scenario.ROBOT_RADIUS * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""Its robots are polygons."""


class Rooms:
    """Environments with robots, which all have the same map.

    Args:
        scenario_: the room, with the robots of all environments.
        count: number of environments.
    """

    def __init__(self, scenario_: Scenario, count: int) -> None:
        self.robots = len(scenario_.poses)
        self._scenario, self._count, self._step = scenario_, count, 0
        team = self.robots // count
        squares = scenario.squares(scenario_.discs, _SQUARE)
        env = JaxNav(
            team,
            rad=scenario.ROBOT_RADIUS,
            map_params={"map_size": squares.shape[::-1], "agent_coords": jnp.asarray(_OUTLINE)},
            lidar_num_beams=scenario.BEAMS,
            lidar_max_range=scenario.RANGE,
            lidar_range_resolution=_RESOLUTION,
            max_v=scenario.SPEED,
            max_w=scenario.YAW_RATE,
            max_v_acc=_FAR,
            max_w_acc=_FAR,
            max_steps=2**30,
            dt=scenario.STEP,
        )
        poses = scenario_.poses.reshape(count, team, 3).astype(np.float32)
        no, zeros = jnp.zeros((count, team), bool), jnp.zeros((count, team, 2))
        self._state = State(
            pos=jnp.asarray(poses[..., :2] + _SQUARE),  # the walls are one square thick
            theta=jnp.asarray(poses[..., 2]),
            vel=zeros,
            done=no,
            term=no,
            goal_reached=no,
            move_term=no,
            step=jnp.zeros(count, int),
            ep_done=jnp.zeros(count, bool),
            goal=zeros - _FAR,
            map_data=jnp.asarray(squares, jnp.int32),
            rew_lambda=jnp.full(count, 0.5),
        )
        axes = State(**{**dict.fromkeys(State.__dataclass_fields__, 0), "map_data": None})
        self._observe = jax.jit(jax.vmap(env._get_obs, in_axes=(axes,)))

        def step(state: Any, commands: Any) -> Any:
            actions = {agent: commands[k] for k, agent in enumerate(env.agents)}
            found = env.step_env(jax.random.PRNGKey(0), state, actions)
            return jnp.stack([found[0][agent] for agent in env.agents]), found[1]

        self._drive = jax.jit(jax.vmap(step, in_axes=(axes, 0), out_axes=(0, axes)))
        commands = scenario_.commands.astype(np.float32)
        self._commands = jnp.asarray(commands.reshape(len(commands), count, team, 2))
        self._drive(self._state, self._commands[0])  # compiles

    def run(self, steps: int) -> None:
        """Commands, steps and scans; the scans are in the observations."""
        for _ in range(steps):
            commands = self._commands[self._scenario.command(self._step)]
            observations, self._state = self._drive(self._state, commands)
            np.asarray(observations)
            self._step += 1

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        observations = np.asarray(self._observe(self._state)).reshape(self.robots, -1)
        return (observations[:, : scenario.BEAMS] + 0.5) * scenario.RANGE

    def close(self) -> None:
        """Does nothing."""


def open_room(kind: str, variant: str, robots: int, seed: int) -> Rooms:
    """Robots in one room, or a batch with a room for each."""
    count = robots if kind == "batch" else 1
    return Rooms(Scenario(robots, seed, rooms=count), count)
