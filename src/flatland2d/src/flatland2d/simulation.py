"""Worlds in a Python program, without ROS: `with Simulation("office") as sim: sim.step()`."""

import os
from typing import (
    TYPE_CHECKING,
    Any,
    Dict,
    Iterable,
    List,
    Mapping,
    NoReturn,
    Optional,
    Sequence,
    Tuple,
    Union,
)

from flatland2d.catalog import Catalog
from flatland2d.handles import ModelHandle
from flatland2d.simulated_topics import SimulatedTopics
from flatland2d.touch import Touch, touches
from flatland2d.world_source import WorldSource, open_world
from flatland_server import _core
from flatland_server.arguments import folders_of, params_of, path_of, several, shown, whole_number
from flatland_server.arrays import FloatArray, PoseLike, UInt8Array
from flatland_server.canvas import Points
from flatland_server.exceptions import ModelError, UsageError, needed_module, unknown
from flatland_server.models import Model
from flatland_server.plugins import PluginLoader
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport import LocalTransport

if TYPE_CHECKING:  # imported when they are needed
    from flatland2d.batch.simulation_batch import SimulationBatch
    from flatland2d.recorder import Recorder
    from flatland2d.rendering.renderer import Renderer


class Simulation(SimulatedTopics):
    """A world that a program steps, without ROS.

        with Simulation("office", seed=1) as sim:
            robot = sim.models["turtlebot"]
            robot.command(0.5, 0.2)
            sim.step(20)
            ranges = robot.sensors["laser"].read()

    The ROS server runs the same code: with equal worlds, seeds and commands, a run equals one of
    the server in lockstep, bit for bit. Values are computed only when they are read. Simulations do
    not affect each other; each is used by one thread at a time.

    Args:
        world: the name of a shipped world such as "office", the path of a world file, the content
            of one as a dict, or a `WorldConfig`, which can be read once for many simulations.
        seed: of all random numbers.
        step_size: length of a step [s].
        topics: the ones subscribed to from the beginning; see `subscribe`.
        params: parameters by absolute name, for expressions in the files and for plugins.
        simplify_map: how much the outlines of map images are simplified: 0 not at all, 1 or 2.
        model_folders: folders to search for model files that are not beside the world file.
        loader: finds plugin classes; by default those that installed packages declare.
        raise_failures: whether the exception of a plugin ends the step with a PluginError;
            otherwise it is logged as by the server. In both cases the plugin is switched off.

    Attributes:
        models: the models by their names, in the order of their creation.

    Raises:
        FlatlandError: there is no such world, something in its files is wrong, or a plugin does not
            start.
    """

    def __init__(
        self,
        world: WorldSource,
        *,
        seed: int = 0,
        step_size: float = 0.005,
        topics: Iterable[str] = (),
        params: Mapping[str, Any] = {},
        simplify_map: int = 0,
        model_folders: Sequence[Union[str, "os.PathLike[str]"]] = (),
        loader: Optional[PluginLoader] = None,
        raise_failures: bool = True,
    ) -> None:
        timekeeper = Timekeeper(step_size)
        self._params, self._loader = params_of(params), loader
        transport = LocalTransport(self._params, ())
        opened = open_world(
            world,
            transport,
            seed=whole_number(seed, "a seed", 0),
            simplify_map=simplify_map,
            model_folders=folders_of(model_folders),
            loader=loader,
        )
        super().__init__(opened, timekeeper, raise_failures=raise_failures)
        self.subscribe(*([topics] if isinstance(topics, str) else several(topics, "topics")))
        self._recorders: List[Recorder] = []
        self._renderer: Optional[Renderer] = None
        self._handles: Dict[str, ModelHandle] = {}
        self._group_models: Tuple[Model, ...] = ()
        self._group = _core.BodyGroup([])
        self.models: Catalog[ModelHandle] = Catalog(
            lambda: self.world.models,
            self._handle,
            lambda name: ModelError(unknown("there is no model", name, self.world.models)),
        )

    def close(self) -> None:
        """Stops all plugins. Later calls raise a UsageError; poses may still be read."""
        try:
            super().close()
        finally:
            for recorder in self._recorders:
                recorder.close()

    # Models

    @property
    def poses(self) -> FloatArray:
        """The poses of all models, in the order of `models`: a new array of shape (models, 3).

        Each row is x, y [m] and yaw in [-pi, pi] [rad] of the model's first body in the world.
        """
        return self._bodies().poses()

    @property
    def velocities(self) -> FloatArray:
        """The velocities of all models, in the order of `models`: a new array (models, 3).

        Each row is vx, vy [m/s] and omega [rad/s] of the origin of the model's first body, in the
        world's frame.
        """
        return self._bodies().velocities()

    @property
    def contacts(self) -> List[Touch]:
        """The pairs of bodies that touched in the last step, in a fixed order."""
        return touches(self.world)

    def spawn(
        self,
        model: Union[str, "os.PathLike[str]", Mapping[str, Any]],
        name: str,
        pose: PoseLike = (0.0, 0.0, 0.0),
        namespace: str = "",
    ) -> ModelHandle:
        """Adds a model: completely, or not at all.

        Args:
            model: the path of a model file, or the content of one as a dict.
            name: unique in the world.
            pose: x, y [m] and yaw [rad] of its origin in the world.
            namespace: of its topics and frames.

        Raises:
            FlatlandError: the file, the name, the namespace or the pose is not usable.
        """
        self.require_open()
        what = "a model's file, or its content as a dict"
        source = model if isinstance(model, (str, Mapping)) else path_of(model, what)
        for text, what in ((name, "the model's name"), (namespace, "the model's namespace")):
            if not isinstance(text, str):
                raise UsageError(f"expected {what} as a string, found {shown(text)}")
        self.world.spawn_model(source, name, namespace, pose)
        return self.models[name]

    def move(self, name: str, pose: PoseLike) -> None:
        """Puts a model at another pose, at rest.

        Args:
            name: the model's name.
            pose: x, y [m] and yaw [rad] of its origin in the world.

        Raises:
            FlatlandError: there is no such model, or the pose is not usable.
        """
        self.require_open()
        self.world.move_model(name, pose)

    def delete(self, name: str) -> None:
        """Removes a model, with its topics.

        Args:
            name: the model's name.

        Raises:
            ModelError: there is no such model.
        """
        self.require_open()
        self.world.delete_model(name)
        self._handles.pop(name, None)

    # Branches

    def __reduce__(self) -> NoReturn:
        raise UsageError("a Simulation is neither copied nor pickled: see branch and save_state")

    def branch(
        self,
        count: int,
        *,
        robot: Optional[str] = None,
        robots: Optional[Sequence[str]] = None,
        lidar: Optional[str] = None,
        threads: int = 1,
        moved: Sequence[str] = (),
    ) -> "SimulationBatch":
        """Continuations of this run, in one call: a batch of environments that begin in its state.

            with sim.branch(100) as batch:
                observation = batch.step(actions)

        Each is, bit for bit, what this run would be with the same commands. This run does not
        change. `batch.reset()` goes back to where they branched off, and
        `batch.load_states(sim.save_state())` on to where this run is by then.

        Args:
            count: number of environments.
            robot: as for `SimulationBatch`.
            robots: as for `SimulationBatch`.
            lidar: as for `SimulationBatch`.
            threads: as for `SimulationBatch`.
            moved: as for `SimulationBatch`.

        Raises:
            FlatlandError: a batch cannot run this world, or its state cannot be saved.
        """
        from flatland2d.batch.simulation_batch import SimulationBatch

        return SimulationBatch(
            self.world.config,
            count,
            robot=robot,
            robots=robots,
            lidar=lidar,
            threads=threads,
            moved=moved,
            step_size=self.step_size,
            params=self._params,
            loader=self._loader,
            state=self.save_state(),
        )

    # Recordings and pictures

    def record(
        self,
        path: Union[str, "os.PathLike[str]"],
        topics: Optional[Iterable[str]] = None,
        *,
        ros2: bool = False,
    ) -> "Recorder":
        """Begins to record topics, the time and the transforms into a file.

            with sim.record("run.bag", topics=["/scan"]):
                sim.step(200)

        Args:
            path: of the file, which ends with .bag or .mcap. It replaces a recording, and nothing
                else. When time goes back, as by a reset, a further file begins: run_1.bag.
            topics: names of topics, or regular expressions that match whole names; by default all.
                They are computed while they are recorded.
            ros2: whether to record messages as ROS 2 has them, into an .mcap.

        Returns:
            A context manager; the recording ends with it, or with `close`, or with the simulation.

        Raises:
            MissingPackageError: messages of ROS 2 need the package rosbags.
            RecordingError: the file cannot be written, or something else than a recording is there.
        """
        from flatland2d.recorder import Recorder

        self.require_open()
        recorder = Recorder(
            self.transport, self.timekeeper, path, topics, lambda: self.world.odometry_frames, ros2
        )
        if not self._recorders:
            self.after_step.append(self._write_recordings)
        self._recorders.append(recorder)
        return recorder

    def render(
        self,
        size: Optional[Tuple[int, int]] = None,
        *,
        follow: Optional[str] = None,
        width: float = 10.0,
        sensors: bool = False,
        names: bool = False,
        trails: Iterable[Points] = (),
    ) -> UInt8Array:
        """A picture of the world as it is now: a new array of shape (height, width, 3).

        Args:
            size: width and height [px]; by default the longer side has 1600 pixels, or both have
                800 if a model is followed.
            follow: the model in the middle of the picture; None shows the whole world.
            width: of the section of the world that is shown around it [m].
            sensors: whether plugins draw what they measure.
            names: whether the names of the models are written beside them.
            trails: lines through positions in the world [m], such as ways of robots.

        Raises:
            FlatlandError: there is no such model, or the size or the width is not usable.
        """
        from flatland2d.rendering.renderer import to_array

        renderer = self._get_renderer()
        view = renderer.view(size, follow=follow, width=width)
        return to_array(renderer.image(view, sensors=sensors, names=names, trails=trails))

    def save_picture(
        self,
        path: Union[str, "os.PathLike[str]"],
        size: Optional[Tuple[int, int]] = None,
        *,
        follow: Optional[str] = None,
        width: float = 10.0,
        sensors: bool = False,
        names: bool = False,
        trails: Iterable[Points] = (),
    ) -> None:
        """Writes a picture into a file.

        Args:
            path: of the file: SVG if it ends in .svg, or else PNG, JPEG ...
            size: as for `render`.
            follow: as for `render`.
            width: as for `render`.
            sensors: as for `render`.
            names: as for `render`.
            trails: as for `render`.

        Raises:
            FlatlandError: as for `render`; or the file cannot be written, or its kind is not known.
        """
        from flatland2d.rendering.renderer import save

        renderer = self._get_renderer()
        view = renderer.view(size, follow=follow, width=width)
        save(path, renderer, view, sensors=sensors, names=names, trails=trails)

    def plot(
        self,
        ax: Optional[Any] = None,
        *,
        follow: Optional[str] = None,
        width: float = 10.0,
        sensors: bool = False,
        names: bool = False,
    ) -> Any:
        """Draws the world into Matplotlib axes, which are in metres, and returns them.

        Args:
            ax: the axes; by default those that pyplot has at present.
            follow: as for `render`.
            width: as for `render`.
            sensors: as for `render`.
            names: as for `render`.

        Raises:
            FlatlandError: as for `render`; or Matplotlib is not installed.
        """
        if ax is None:
            install = "pip install matplotlib"
            ax = needed_module("matplotlib.pyplot", "a plot needs Matplotlib", install).gca()
        renderer = self._get_renderer()
        view = renderer.view(follow=follow, width=width)
        image = renderer.image(view, sensors=sensors, names=names)
        ax.imshow(image, extent=view.extent, interpolation="antialiased")
        ax.set_xlabel("x [m]")
        ax.set_ylabel("y [m]")
        return ax

    def _repr_png_(self) -> bytes:
        """The picture that a notebook shows of a simulation."""
        from flatland2d.rendering.renderer import to_png

        renderer = self._get_renderer()
        return to_png(renderer.image(renderer.view()))

    def _get_renderer(self) -> "Renderer":
        from flatland2d.rendering.renderer import Renderer

        if self._renderer is None:
            self._renderer = Renderer(self.world, self.timekeeper)
        return self._renderer

    def _write_recordings(self) -> None:
        """Writes the step to the recordings that are open."""
        self._recorders = [each for each in self._recorders if each.is_open]
        for recorder in self._recorders:
            recorder.write_step()
        if not self._recorders:
            self.after_step.remove(self._write_recordings)

    def _handle(self, name: str) -> ModelHandle:
        if name not in self._handles:
            self._handles[name] = ModelHandle(self, name)
        return self._handles[name]

    def _bodies(self) -> _core.BodyGroup:
        """The first bodies of all models."""
        models = tuple(self.world.contents.models.values())
        if models != self._group_models:
            self._group = _core.BodyGroup([model.base.physics_body for model in models])
            self._group_models = models
        return self._group
