"""A simulation that shows an environment of a batch: for pictures."""

from dataclasses import dataclass, field
from typing import Any, Callable, List, Mapping, Optional, Tuple

from flatland2d.simulation import Simulation
from flatland_server import _core
from flatland_server.arrays import FloatArray
from flatland_server.plugins import PluginLoader
from flatland_server.simulation import World, WorldConfig


@dataclass
class BatchView:
    """Makes a `Simulation` when it is first needed, and later only moves its bodies.

    Args:
        world: the batch's world.
        step_size: length of a step [s].
        params: parameters of the world's plugins, by name.
        loader: finds their classes.
        origin: the state in which environments begin, if it is not that of the world's files.
    """

    world: World
    step_size: float
    params: Mapping[str, Any]
    loader: Optional[PluginLoader]
    origin: Optional[bytes] = None
    _simulation: Optional[Simulation] = field(default=None, init=False)
    _differences: Tuple[Any, Any] = field(default=(None, None), init=False)

    @property
    def bodies(self) -> List[_core.Body]:
        """The bodies of all models of the batch's world, in the order of `show`'s poses."""
        return _bodies_of(self.world)

    def show(
        self,
        seed: int,
        nanoseconds: int,
        poses: FloatArray,
        velocities: FloatArray,
        differences: Tuple[Optional[_core.Walls], Optional[Mapping[str, float]]],
        config: Callable[[], WorldConfig],
    ) -> Simulation:
        """The simulation with a seed, at a time, with its bodies at these poses (n, 3).

        Args:
            seed: of the environment.
            nanoseconds: the time.
            poses: of its bodies.
            velocities: of its bodies.
            differences: from other environments: its walls and numbers.
            config: makes its world.
        """
        if differences != self._differences:
            self.close()
            self._simulation, self._differences = None, differences
        if self._simulation is None:
            self._simulation = Simulation(
                config(),
                seed=seed,
                step_size=self.step_size,
                params=self.params,
                loader=self.loader,
            )
            if self.origin is not None:
                self._simulation.load_state(self.origin)
        elif self._simulation.seed != seed and self.origin is None:
            self._simulation.reset(seed)
        bodies = _bodies_of(self._simulation.world)
        for body, pose, velocity in zip(bodies, poses.tolist(), velocities.tolist()):
            body.pose, body.velocity = tuple(pose), tuple(velocity)
        self._simulation.timekeeper.jump_to(nanoseconds)
        return self._simulation

    def close(self) -> None:
        """Closes the simulation."""
        if self._simulation is not None:
            self._simulation.close()


def _bodies_of(world: World) -> List[_core.Body]:
    """The bodies of all models, in the order of their creation."""
    return [body for model in world.models.values() for body in model.physics_bodies]
