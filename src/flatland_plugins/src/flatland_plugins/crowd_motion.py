"""Motion of a crowd at its updates, in one world or in all environments of a batch at once."""

from typing import Any, Callable, List, Optional, Sequence, Tuple

import numpy as np

from flatland_plugins.crowd_config import Build, WalkConfig
from flatland_plugins.obstacles import Outline, Walls, seen_from, seen_walls
from flatland_plugins.people import People, Person, Progress
from flatland_plugins.social_force import Others, SocialForce, discs_apart, limit
from flatland_server import (
    BatchMotion,
    Body,
    FloatArray,
    IntArray,
    Segments,
    UpdateTimer,
    wrap_angle,
)

_MOST_SPEED = 1.3
"""Maximum speed over desired speed (Helbing and Molnar, Phys. Rev. E 51, 1995)."""

_REACH = 8.0
"""Reach of walls, in ranges of the repulsion: it has fallen to e^-8 there."""

_ALONE = np.array([0])
"""The index of the only world of a simulation."""


class CrowdMotion(BatchMotion):
    """The people of a crowd in n worlds.

    Args:
        config: how they walk.
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
        config: WalkConfig,
        walls: Walls,
        see_walls: Callable[[Sequence[Segments]], Walls],
        people: Sequence[Person],
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

    def _set_people(self, people: Sequence[Person]) -> None:
        self.people = list(people)
        self._people = People([each.config for each in people])
        legs = [leg for each in people for leg in each.legs]
        circles = [each.circle for each in people if each.circle is not None]
        self._in_circles = [i for i, each in enumerate(people) if each.circle is not None]
        bodies = [*(each.body for each in people), *legs, *circles]
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

    def get_state(self, environment: int) -> Any:
        """The goal and the stride of each person, by name."""
        goals, strides = (values[environment].tolist() for values in self.progress)
        names = [person.config.name for person in self.people]
        return {name: each for name, *each in zip(names, goals, strides)}

    def set_state(self, environment: int, state: Any) -> None:
        for index, person in enumerate(self.people):
            for values, value in zip(self.progress, state[person.config.name]):
                values[environment, index] = value

    def update(
        self, environments: IntArray, poses: FloatArray, velocities: FloatArray, step_size: float
    ) -> FloatArray:
        """The velocities until the next update; see `BatchMotion`."""
        config, count, dt = self._config, len(self._people), self.time_of(step_size)
        moved, bodies = len(self.moved), poses[:, :count]
        goals, ways = self._people.ways(
            self.progress.goals[environments],
            bodies[..., :2],
            config.goal_radius,
            time_left=2.0 * config.force.relaxation_time,
        )
        walk = self._velocities(
            environments.tolist(),
            ways,
            bodies[..., :2],
            velocities[:, :count, :2],
            (poses[:, moved:], velocities[:, moved:]),
            self._noise(environments, dt),
            dt,
        )
        self.progress.goals[environments] = goals
        return self.walk(environments, poses, walk, step_size)

    def walk(
        self, environments: IntArray, poses: FloatArray, velocities: FloatArray, step_size: float
    ) -> FloatArray:
        """The velocities of bodies and legs of people that walk at these velocities.

        Args:
            environments: as in `update`.
            poses: as in `update`.
            velocities: of the people, (k, p, 2) [m/s].
            step_size: as in `update`.

        Returns:
            As `update`.
        """
        people, dt = self._people, self.time_of(step_size)
        count, moved = len(people), len(self.moved)
        bodies, motion = poses[:, :count], np.zeros_like(poses[:, :moved])
        walk = motion[:, :count]
        walk[..., :2] = velocities
        walk[..., 2] = people.turns(bodies[..., 2], velocities, dt) / dt
        if moved > count:
            strides, legs = people.step(self.progress.strides[environments], bodies, walk, dt)
            self.progress.strides[environments] = strides
            places = legs.reshape(len(legs), -1, 2)
            if self._in_circles:
                circles = (bodies + walk * dt)[:, self._in_circles, :2]
                places = np.concatenate([places, circles], axis=1)
            motion[:, count:, :2] = (places - poses[:, count:moved, :2]) / dt
        return motion

    def update_alone(self, step_size: float, velocity: Optional[Sequence[float]] = None) -> None:
        """Sets the velocities in the only world of a simulation.

        Args:
            step_size: of the simulation [s].
            velocity: of the people [m/s]; None: by the forces.
        """
        poses = poses_of(self.bodies)
        if velocity is None:
            velocities = np.array([[body.velocity for body in self.bodies]])
            new = self.update(_ALONE, poses, velocities, step_size)
        else:
            new = self.walk(_ALONE, poses, np.array([[velocity]]), step_size)
        for body, each in zip(self.moved, new[0].tolist()):
            body.velocity = tuple(each)

    def time_of(self, step_size: float) -> float:
        """The time from one update to the next [s]."""
        return max(self._period, step_size)

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


def reach_of(builds: Sequence[Build], force: SocialForce) -> float:
    """The distance within which walls repel people of these builds [m]."""
    return max((build.radius for build in builds), default=0.0) + _REACH * force.range


def poses_of(bodies: Sequence[Body]) -> FloatArray:
    """The poses of bodies, the yaw within [-pi, pi]: shape (1, n, 3)."""
    poses = np.array([body.pose for body in bodies]).reshape(1, -1, 3)
    poses[..., 2] = [[wrap_angle(yaw) for yaw in poses[0, :, 2]]]
    return poses
