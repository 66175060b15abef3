"""The handles of a simulation's models and of their plugins."""

import inspect
from typing import Any, Callable, ClassVar, Dict, Generic, List, Tuple, TypeVar, overload

from flatland2d.catalog import Catalog
from flatland2d.robot import plugins_with
from flatland_server.arguments import finite, shown
from flatland_server.arrays import FloatArray
from flatland_server.exceptions import (
    ModelError,
    PluginError,
    UsageError,
    listed,
    shortened,
    suggestion,
    unknown,
)
from flatland_server.geometry import Pose, Velocity
from flatland_server.models import Model
from flatland_server.plugins import ModelPlugin, Plugin
from flatland_server.simulation import RunWithHistory
from flatland_server.timekeeper import Timekeeper

Reading = TypeVar("Reading")


class ModelHandle:
    """A model of a simulation, by its name.

    It stays valid when the simulation is reset or a state is loaded: it then refers to the new
    model of this name. Once the model has been deleted, everything but `name` raises a ModelError.

    Args:
        simulation: the model's simulation.
        name: the model's name.

    Attributes:
        name: the model's name.
        sensors: the plugins that measure something, by their names; see `ModelPlugin.read`.
        drives: the plugins that take commands, by their names; see `ModelPlugin.command`.
    """

    def __init__(self, simulation: RunWithHistory, name: str) -> None:
        self.name = name
        self._simulation = simulation
        self._current = simulation.world.plugin_revision
        self._command_revision = -1  # of the drive that `_command` belongs to
        self._command: Callable[..., None]
        self._revision = -1  # of the plugins that are kept here
        self._running: Dict[str, Plugin] = {}
        self._names: Dict[str, List[str]] = {}
        self._sensors: Dict[str, SensorHandle[Any]] = {}
        self._drives: Dict[str, DriveHandle] = {}
        self.sensors: Catalog[SensorHandle[Any]] = Catalog(
            lambda: self._plugins_with("read"),
            self._sensor,
            lambda plugin: self._unknown("sensor", plugin, self._plugins_with("read")),
        )
        self.drives: Catalog[DriveHandle] = Catalog(
            lambda: self._plugins_with("command"),
            self._drive,
            lambda plugin: self._unknown("drive", plugin, self._plugins_with("command")),
        )

    @property
    def model(self) -> Model:
        """The model, with its bodies and joints; another object after each reset."""
        return self._simulation.world.get_model(self.name)

    @property
    def namespace(self) -> str:
        """The namespace of its topics and frames."""
        return self.model.namespace

    @property
    def pose(self) -> Pose:
        """The pose of its first body in the world: a row of `Simulation.poses`."""
        return self.model.base.pose

    @property
    def velocity(self) -> Velocity:
        """The velocity of its first body in the world's frame: a row of `Simulation.velocities`."""
        return Velocity(*self.model.base.physics_body.velocity)

    @property
    def local_velocity(self) -> Velocity:
        """The same in the frame of the body: forwards, to the left, counter-clockwise."""
        return Velocity(*self.model.base.physics_body.local_velocity)

    def command(self, *values: Any) -> None:
        """Commands its drive; takes effect at the next step, and until the next command.

        A model with several drives has one each in `drives`.

        Args:
            values: for a DiffDrive, a velocity and a yaw rate [m/s, rad/s]; for an OmniDrive, vx,
                vy [m/s] and the yaw rate; for a TricycleDrive, the speed [m/s] and the angle [rad]
                of its front wheel; for an AckermannDrive, those of the car.

        Raises:
            UsageError: the number of values is wrong, or one is not finite.
            ModelError: the model has no drive, or several ones.
        """
        if self._command_revision != self._current.value:
            self._command = self._only_drive().command
            self._command_revision = self._current.value
        self._command(*values)

    def __repr__(self) -> str:
        return f'<model "{self.name}">'

    def plugin(self, name: str) -> ModelPlugin:
        """A running plugin; another object after each reset.

        Args:
            name: the plugin's name.

        Raises:
            ModelError: the model is gone, or has no plugin of this name.
            PluginError: it has failed, and is switched off.
            UsageError: the simulation is closed.
        """
        plugins = self._plugins()
        if name not in plugins:
            for failure in self._simulation.world.plugin_failures:
                if (failure.owner, failure.name) == (self.name, name):
                    raise PluginError(f'the plugin "{failure.label}" failed in {failure.reason}')
            raise self._unknown("plugin", name, list(plugins))
        plugin = plugins[name]
        assert isinstance(plugin, ModelPlugin)
        return plugin

    def _plugins(self) -> Dict[str, Plugin]:
        """The running plugins by name, kept until plugins of the world come or go."""
        if self._revision != self._current.value:
            world = self._simulation.world
            self._simulation.require_open()
            world.get_model(self.name)
            self._running = world.plugins_of(self.name)
            self._names = {}
            self._revision = self._current.value
        return self._running

    def _plugins_with(self, hook: str) -> List[str]:
        """The names of the plugins that override a hook, in their order."""
        plugins = self._plugins()
        if hook not in self._names:
            self._names[hook] = plugins_with(plugins, hook)
        return self._names[hook]

    def _only_drive(self) -> "DriveHandle":
        """Its only drive; raises a ModelError if it has none or several."""
        names = self._plugins_with("command")
        if len(names) != 1:
            found = f"has {listed(names)}: use drives[...].command" if names else "has none"
            raise ModelError(f'expected a model with one drive, "{self.name}" {found}')
        return self._drive(names[0])

    def _sensor(self, name: str) -> "SensorHandle[Any]":
        if name not in self._sensors:
            self._sensors[name] = SensorHandle(self, name)
        return self._sensors[name]

    def _drive(self, name: str) -> "DriveHandle":
        if name not in self._drives:
            self._drives[name] = DriveHandle(self, name)
        return self._drives[name]

    def _unknown(self, kind: str, name: str, known: List[str]) -> ModelError:
        problem = f'the model "{self.name}" has no {kind}'
        return ModelError(unknown(problem, name, known, "it has"))


class _PluginHandle:
    """The common part of the handles of plugins."""

    _kind: ClassVar[str]

    def __init__(self, model: ModelHandle, name: str) -> None:
        self.name = name
        self._model = model
        self._simulation = model._simulation
        self._current = model._current
        self._revision = -1  # of the plugin's method that is kept

    @property
    def type(self) -> str:
        """The type of the plugin, such as "Laser" or "DiffDrive"."""
        return self._model.plugin(self.name).type

    def __repr__(self) -> str:
        return f'<{self._kind} "{self._model.name}/{self.name}">'


class SensorHandle(_PluginHandle, Generic[Reading]):
    """A plugin that measures something, by its name; see `ModelPlugin.read`.

    The kind of a sensor is known from the world's files alone. To declare it for type checkers:

        laser: SensorHandle[Float32Array] = robot.sensors["laser"]

    Args:
        model: the plugin's model.
        name: the plugin's name.

    Attributes:
        name: the plugin's name.
    """

    _kind = "sensor"
    _read: Callable[[Timekeeper], Any]

    @property
    def quantities(self) -> Tuple[str, ...]:
        """The quantities that `read` can return besides its default one."""
        return self._model.plugin(self.name).quantities

    @property
    def angles(self) -> FloatArray:
        """The directions of a lidar's beams in its frame, as in its messages [rad], (n,).

        These properties raise a UsageError if the sensor has no such thing.
        """
        angles: FloatArray = self._fact("angles")
        return angles

    @property
    def range_max(self) -> float:
        """The largest distance that a lidar measures [m]."""
        return float(self._fact("range_max"))

    @property
    def frame_id(self) -> str:
        """The frame of its messages."""
        return str(self._fact("frame_id"))

    @property
    def period(self) -> float:
        """The time between two messages [s]; 0 if there is one at each step."""
        timer = self._fact("update_timer")
        return 0.0 if timer is None else float(timer.period)

    @overload
    def read(self) -> Reading: ...

    @overload
    def read(self, quantity: str) -> Any: ...

    def read(self, quantity: str = "") -> Any:
        """Measures now, at the time of the simulation.

        The result equals the content of a message at this time, noise included; the run does not
        change. docs/library.md lists the results of the built-in sensors: a new object each time.

        Args:
            quantity: one of `quantities`; by default the main one, such as a laser's ranges.

        Raises:
            ModelError: the model or the plugin is gone.
            PluginError: the plugin has failed, and is switched off.
            UsageError: it does not measure this quantity, or the simulation is closed.
        """
        if not quantity:
            if self._revision != self._current.value:
                self._read = self._model.plugin(self.name).read
                self._revision = self._current.value
            return self._read(self._simulation.timekeeper)
        plugin = self._model.plugin(self.name)
        known = plugin.quantities
        if quantity not in known:
            raise UsageError(
                f'the sensor "{plugin.node.owner}" does not measure "{shortened(quantity)}"'
                f"{suggestion(quantity, known)}; besides what read() gives: {listed(known)}"
            )
        return getattr(plugin, f"read_{quantity}")(self._simulation.timekeeper)

    def _fact(self, name: str) -> Any:
        """An attribute of the plugin."""
        plugin = self._model.plugin(self.name)
        if not hasattr(plugin, name):
            raise UsageError(f'the sensor "{plugin.node.owner}", a {plugin.type}, has no {name}')
        return getattr(plugin, name)


class DriveHandle(_PluginHandle):
    """A plugin that takes commands, by its name; see `ModelPlugin.command`.

    Args:
        model: the plugin's model.
        name: the plugin's name.

    Attributes:
        name: the plugin's name.
    """

    _kind = "drive"
    _command: Callable[..., None]

    def command(self, *values: Any) -> None:
        """Commands it; takes effect at the next step. See `ModelHandle.command`.

        Args:
            values: those that the drive takes; see `ModelHandle.command`.

        Raises:
            UsageError: the number of values is wrong, or one is not finite.
        """
        if self._revision != self._current.value:
            self._command = self._model.plugin(self.name).command
            self._revision = self._current.value
        finite(values, "a command")
        try:
            self._command(*values)
        except (TypeError, ValueError) as error:
            raise self._wrong_command(values, error) from error
        on_input = self._simulation.transport.on_input
        if on_input is not None:
            on_input((self._model.name, self.name), values)

    def _wrong_command(self, values: Tuple[Any, ...], error: Exception) -> UsageError:
        """The error for a command that the plugin has refused by raising this error."""
        signature = inspect.signature(self._command)
        reason = ""
        try:
            signature.bind(*values)
            reason = f": {error}"
        except TypeError:
            pass
        owner = self._model.plugin(self.name).node.owner
        return UsageError(
            f'the drive "{owner}" takes command({", ".join(signature.parameters)}), '
            f"found {shown(values)}{reason}"
        )
