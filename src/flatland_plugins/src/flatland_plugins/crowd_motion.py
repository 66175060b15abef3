"""Motion of a crowd at its updates, in one world or in all environments of a batch at once."""

from typing import Callable, List, Optional, Sequence, Tuple

import numpy as np

from flatland_plugins.crowd_config import CrowdConfig
from flatland_plugins.obstacles import Outline, Walls, seen_from, seen_walls
from flatland_plugins.people import Pedestrian, People, Progress
from flatland_plugins.social_force import Others, discs_apart, limit
from flatland_server import BatchMotion, FloatArray, IntArray, Segments, UpdateTimer

_MOST_SPEED = 1.3
"""Maximum speed over desired speed (Helbing and Molnar, Phys. Rev. E 51, 1995)."""


class CrowdMotion(BatchMotion):
    """The people of a crowd in n worlds.

    Args:
        config: of the crowd.
        walls: of the world, as far as the people see them.
        see_walls: selects the walls that people see from the walls of each layer.
        people: those that exist, p.
        outlines: the other bodies that they see.
        count: number of worlds, n.

    Attributes:
        people: those that exist.
        progress: of the people, in all worlds.
    """

    def __init__(
        self,
        config: CrowdConfig,
        walls: Walls,
        see_walls: Callable[[Sequence[Segments]], Walls],
        people: Sequence[Pedestrian],
        outlines: Sequence[Outline],
        count: int = 1,
    ) -> None:
        super().__init__(config.update_rate)
        self._period = UpdateTimer(config.update_rate).period
        self._config = config
        self._shared, self._see_walls = walls, see_walls
        self._walls = [walls] * count
        self._outlines = outlines
        self._set_people(people)
        self.progress = Progress.of(count, len(people))
        self._rngs: List[np.random.Generator] = [np.random.default_rng(0)] * count

    def see(self, outlines: Sequence[Outline]) -> None:
        """Sets the other bodies that the people see."""
        self._outlines = outlines
        self.bodies = [*self.moved, *(each.body for each in outlines)]

    def keep(self, indices: List[int]) -> None:
        """Drops all people but these."""
        self._set_people([self.people[index] for index in indices])
        goals, strides = self.progress
        self.progress = Progress(goals[:, indices], strides[:, indices])

    def _set_people(self, people: Sequence[Pedestrian]) -> None:
        self.people = list(people)
        self._people = People([each.config for each in people])
        legs = [each.model.bodies[leg] for each in people for leg in each.legs]
        bodies = [*(each.model.base for each in people), *legs]
        self.moved = [body.physics_body for body in bodies]
        self.see(self._outlines)

    def begin(
        self,
        environment: int,
        rng: np.random.Generator,
        walls: Optional[Sequence[Segments]],
    ) -> None:
        """Resets the people of a world."""
        self._rngs[environment] = rng
        self._walls[environment] = self._shared if walls is None else self._see_walls(walls)
        for values, initial in zip(self.progress, Progress.of(1, len(self.people))):
            values[environment] = initial[0]

    def update(
        self, environments: IntArray, poses: FloatArray, velocities: FloatArray, step_size: float
    ) -> FloatArray:
        """The velocities until the next update; see `BatchMotion`."""
        config, people, dt = self._config, self._people, max(self._period, step_size)
        count = len(people)
        moved = count + 2 * len(people.walkers)
        bodies, motion = poses[:, :count], np.zeros_like(poses[:, :moved])
        walk, time_left = motion[:, :count], 2.0 * config.force.relaxation_time
        goals, ways = people.ways(
            self.progress.goals[environments], bodies[..., :2], config.goal_radius, time_left
        )
        walk[..., :2] = self._velocities(
            environments.tolist(),
            ways,
            bodies[..., :2],
            velocities[:, :count, :2],
            (poses[:, moved:], velocities[:, moved:]),
            self._noise(environments, dt),
            dt,
        )
        walk[..., 2] = people.turns(bodies[..., 2], walk[..., :2], dt) / dt
        self.progress.goals[environments] = goals
        if moved > count:
            strides, legs = people.step(self.progress.strides[environments], bodies, walk, dt)
            self.progress.strides[environments] = strides
            legs = legs.reshape(len(legs), -1, 2)
            motion[:, count:, :2] = (legs - poses[:, count:moved, :2]) / dt
        return motion

    def _noise(self, environments: IntArray, dt: float) -> FloatArray:
        """Noise of the velocities [m/s], (n, p, 2)."""
        numbers = np.empty((len(environments), len(self.people), 2))
        for row, index in zip(numbers, environments.tolist()):
            self._rngs[index].standard_normal(out=row)
        return self._config.force.scatter(numbers, dt)

    def _velocities(
        self,
        environments: List[int],
        ways: FloatArray,
        points: FloatArray,
        velocities: FloatArray,
        others: Tuple[FloatArray, FloatArray],
        noise: FloatArray,
        dt: float,
    ) -> FloatArray:
        """The velocities after `dt` [s], (n, p, 2).

        Args:
            environments: the indices of the n worlds.
            ways: the desired directions, (n, p, 2).
            points: of the people [m], (n, p, 2).
            velocities: the present ones [m/s], (n, p, 2).
            others: poses and velocities of the other bodies, (n, m, 3) each.
            noise: of the velocities [m/s], (n, p, 2).
            dt: [s].
        """
        force, people, (worlds, count) = self._config.force, self._people, points.shape[:2]
        radii, speeds = np.tile(people.radii, worlds), np.tile(people.speeds, worlds)
        rows, way = points.reshape(-1, 2), ways.reshape(-1, 2)
        will = np.hypot(way[:, :1], way[:, 1:])  # a person that stands neither evades nor sways

        to_walls = seen_walls([self._walls[k] for k in environments], points).nearer_by(radii)
        seen = seen_from(rows, self._outlines, np.repeat(others[0], count, axis=0))
        to_bodies = seen.nearer_by(radii)
        distances, away = discs_apart(points, people.radii)
        apart = Others(distances.reshape(-1, count), away.reshape(-1, count, 2))
        own = velocities[:, :, np.newaxis]
        past_people = (own - velocities[:, np.newaxis]).reshape(-1, count, 2)
        past_bodies = (own - others[1][:, np.newaxis, :, :2]).reshape(len(rows), -1, 2)
        repulsion = force.repel(apart) + force.repel(to_bodies) + force.repel(to_walls)
        evasion = force.evade(apart, past_people) + force.evade(to_bodies, past_bodies)

        after = velocities.reshape(-1, 2)
        after = force.relax(after, speeds[:, np.newaxis] * way, repulsion + will * evasion, dt)
        after += will * noise.reshape(-1, 2)
        return limit(after, _MOST_SPEED * speeds).reshape(worlds, count, 2)
