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


class Room:
    """Environments with robots, which all have the same map.

    Args:
        layout: the scenario.
    """

    def __init__(self, layout: Scenario) -> None:
        count, team = layout.rooms, len(layout.poses) // layout.rooms
        squares = scenario.squares(layout.discs, _SQUARE)
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
        poses = layout.poses.reshape(count, team, 3).astype(np.float32)
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
        commands = layout.commands.astype(np.float32)
        self.commands = jnp.asarray(commands.reshape(len(commands), count, team, 2))
        self._drive(self._state, self.commands[0])  # compiles

    def step(self, commands: Any) -> None:
        """Commands, steps and scans; the scans are in the observations."""
        observations, self._state = self._drive(self._state, commands)
        np.asarray(observations)

    def scans(self) -> Any:
        """The ranges of all lidars [m]."""
        observations = np.asarray(self._observe(self._state))
        ranges = observations.reshape(-1, observations.shape[-1])[:, : scenario.BEAMS]
        return (ranges + 0.5) * scenario.RANGE


Batch = Room
