"""Flatland's physics and ray casting on Box2D; see include/flatland_server/world.hpp.

Lengths are in m, angles in rad, counter-clockwise from +x, times in s. A pose is (x, y, yaw), a
twist (vx, vy, omega).

Body, Fixture, Joint and so on are handles, which name objects of the C++ core. Their methods and
properties raise, unless it is said otherwise:

    GoneError: the object has been removed from its world.
    ValueError: Box2D cannot compute with a value: it is not finite or too large, or a shape has no
        area. Nothing has changed.
    RuntimeError: another thread uses the world; or a contact listener tries to add, remove or move
        something.
"""

from typing import Any, Callable, Iterator, NoReturn, Sequence, overload

import numpy as np
import numpy.typing as npt

from flatland_server.arrays import BoolArray, Float32Array, FloatArray, IntArray, Numbers, Segments

_Pair = tuple[float, float]
_Triple = tuple[float, float, float]
_PairLike = Numbers
_TripleLike = Numbers
_Axis = Sequence[float]
_Actuators = tuple[_Axis, _Axis, float, int, _TripleLike]
_Collision = tuple[int, Fixture, Fixture, bool, list[_Pair], _Pair, list[float]]

class _Metaclass(type):
    """The metaclass of pybind11."""

class _WithoutConstructor(metaclass=_Metaclass):
    """Base of the classes that Python code cannot construct: methods return their objects."""

    def __init__(self, *args: object, **kwargs: object) -> NoReturn:
        """Raises TypeError."""

class GoneError(ReferenceError):
    """A handle of an object that has been removed from its world is used."""

class World(metaclass=_Metaclass):
    """A physical world.

    Args:
        velocity_iterations: velocity iterations of the solver in each step, 1 or more.
        position_iterations: position iterations of the solver in each step, 1 or more.
    """

    def __init__(self, velocity_iterations: int = 10, position_iterations: int = 10) -> None: ...
    def add_layer(
        self,
        segments: Segments,
        layers: int,
        progress: Callable[[int], None] | None = None,
    ) -> Body:
        """Adds a static body of two-sided walls, one fixture each. It cannot be moved or removed.

        Box2D has those near dynamic bodies.

        Args:
            segments: shape (n, 4), rows of x1, y1, x2, y2 [m].
            layers: bits of the collision layers of all walls.
            progress: called with the number of walls added so far, about every 50,000 and at the
                end. It must not use the world.
        """
    def add_body(
        self,
        type: str,
        pose: _TripleLike,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
    ) -> Body:
        """Adds a body without fixtures.

        Args:
            type: static, kinematic or dynamic.
            pose: of its origin, in the world [m, m, rad].
            linear_damping: 0 or more [1/s].
            angular_damping: 0 or more [1/s].
        """
    def add_crowd(
        self,
        key: int,
        *,
        layers: int,
        period: float,
        goal_radius: float,
        forces: tuple[float, float, float, float, float, float],
        orca: tuple[float, float, float, int] | None = None,
        begin: float = 0.0,
    ) -> Crowd:
        """Adds a crowd without people, which moves them in the steps.

        Args:
            key: of the random numbers, from 0 to 2^64 - 1. Equal keys give equal numbers.
            layers: bits of the collision layers on which people avoid walls and bodies.
            period: from one update of the velocities to the next [s]; 0: each step.
            goal_radius: distance at which a goal counts as reached [m].
            forces: the constants of the social force model: the relaxation time [s], the repulsion
                [m/s^2] and its range [m], the evasion [m/s^2], the preference of a side [rad/m],
                and the noise of the velocity [m/s].
            orca: moves them by optimal reciprocal collision avoidance instead: time without
                collisions with people and robots, and with walls [s], the distance up to which
                people count [m], and how many of them.
            begin: the time of its people's recordings at time 0 [s].
        """
    def step(self, dt: float) -> None:
        """Advances the simulation by `dt` [s], 1e-9 or more. Releases the GIL.

        Raises:
            Exception: raised by the contact listener; the step is complete.
        """
    def step_until_contact(self, dt: float, count: int) -> int:
        """Makes at most `count` steps, and at least one, as `step` does.

        It ends after a step in which the contact listener was called.

        Args:
            dt: length of each step [s], 1e-9 or more.
            count: 1 or more.

        Returns:
            The number of steps.

        Raises:
            Exception: raised by the contact listener; the step is complete.
        """
    @property
    def completed_steps(self) -> int:
        """Number of steps that the last call of `step_until_contact` has completed.

        In the contact listener, the present step does not count.
        """
    def scan(
        self,
        fan: BeamFan,
        pose: _TripleLike,
        range: float,
        layers: int = 0xFFFF,
        reflectance_layers: int = 0,
    ) -> tuple[Float32Array, Float32Array]:
        """Scans from any pose, without a lidar on a body. Releases the GIL.

        Args:
            fan: directions of the n beams.
            pose: in the world [m, m, rad].
            range: largest distance that is measured [m].
            layers: bits of the collision layers that are seen.
            reflectance_layers: bits of those layers that return an intensity of 255.

        Returns:
            Ranges, shape (n,): the distance of the nearest hit of each beam [m], or +infinity
            (REP 117). Intensities, shape (n,): 255 for hits on reflectance layers, else 0. Shapes
            that contain the pose are not seen.
        """
    @property
    def settings(self) -> FloatArray:
        """The numbers that steps leave as they are, in an order of the core's: a new array.

        Of drives, lidars, and bodies with their footprints; see settings.hpp.
        """
    def save_state(self) -> bytes:
        """The dynamic state: poses, velocities, masses, contacts, joints, drives and tweens.

        This world and one that `restore_state` puts into this state run alike, bit for bit.
        """
    def restore_state(self, state: bytes) -> None:
        """Restores the saved state of a world that was built in the same way and order.

        Bodies, joints and so on stay valid, and no contact event is reported.

        Raises:
            ValueError: the state is damaged or does not fit this world. Nothing has changed.
        """
    def set_contact_listener(self, listener: Callable[..., None] | None) -> None:
        """Sets the function that receives contact events, or None.

        It is called as `listener(event, id_a, id_b, contact)` within `step`, and within
        `Body.remove` for the contacts that end by it. Which events of which bodies it receives is
        chosen by `Body.listen_to_contacts`. `id_a` and `id_b` are the `Body.id` of the two bodies.
        A fifth argument is, at PRE_SOLVE, the Manifold of the previous step, and at POST_SOLVE the
        ContactImpulse. After its first exception it is not called any more in that step, and `step`
        or `remove` raises the exception at its end.
        """
    @property
    def touches(self) -> list[tuple[Fixture, Fixture, list[_Pair], _Pair]]:
        """Pairs of fixtures that touched in the last step, in a fixed order.

        Each entry has the two fixtures, up to two contact points in the world [m], and the unit
        vector from the first to the second in the world's frame. If one is a sensor, there are no
        points and the vector is zero.
        """
    @property
    def body_count(self) -> int:
        """Number of bodies, layers included."""
    @property
    def joint_count(self) -> int:
        """Number of joints."""
    @property
    def grip_count(self) -> int:
        """Number of drives of limited force."""

class Walls(metaclass=_Metaclass):
    """The walls of a layer, with what lidars need of them: a map for environments of a batch.

    Equal ones are shared. Environments that have it keep it alive.

    Args:
        segments: shape (n, 4), x1, y1, x2, y2 [m].

    Raises:
        ValueError: they have another shape, are not finite or farther than 100 km from the origin.
    """

    def __init__(self, segments: Segments) -> None: ...
    def __len__(self) -> int: ...
    @property
    def segments(self) -> Segments:
        """The segments: a new array."""

class WorldBatch(metaclass=_Metaclass):
    """Environments with the same initial world and m robots each; see world_batch.hpp.

    Arrays have a row for each robot, the m of the first environment first. `out` has arrays that
    are written to in place: ranges (n * m, beams) float32, poses, velocities and local velocities
    (n * m, 3) float64, collided (n * m,) bool, steps (n,) int64.

    Args:
        world: the initial world, which is copied.
        robots: of each, its bodies, the first of which is observed; the pose of that body in the
            robot's frame; its drive; the index of the drive's number that each number of an action
            sets; and its lidar.
        count: number of environments, n.
        threads: number of threads that share the environments.
        models: models that `reset` can move: the bodies of each, and the pose of the first body in
            the model's frame.
        steps: number of steps that the world has made.
        varied: the indices of those of `World.settings` that `set_settings` sets.
    """

    def __init__(
        self,
        world: World,
        *,
        robots: Sequence[
            tuple[Sequence[Body], _TripleLike, Drive | Tricycle | Ackermann, Sequence[int], Lidar]
        ],
        count: int,
        threads: int,
        models: Sequence[tuple[Sequence[Body], _Triple]],
        steps: int = 0,
        varied: Sequence[int] = ...,
    ) -> None: ...
    @property
    def beams(self) -> int:
        """The number of beams of the lidar."""
    def require_actions(self, actions: FloatArray, mask: BoolArray | None) -> None:
        """Checks actions as `step` does.

        Raises:
            ValueError: an array does not fit, or a number is not finite; names the place.
        """
    def step(
        self,
        actions: FloatArray,
        substeps: int,
        dt: float,
        out: tuple[Any, ...] | None,
        goes_on: bool = False,
        mask: BoolArray | None = None,
    ) -> None:
        """Commands the robots, makes steps of `dt` [s], and writes the rows. Releases the GIL.

        With None as `out`, no row is written. With `goes_on`, collisions of the previous call count
        in the rows, too. With a mask (n * m,), only the environments of its robots are stepped,
        their rows written, and their actions read; other robots of these are commanded to stop.

        Raises:
            ValueError: an array does not fit, or a number is not finite. Nothing has changed.
        """
    def reset(
        self,
        mask: BoolArray | None,
        poses: FloatArray | None,
        out: tuple[Any, ...],
        model_poses: FloatArray | None,
    ) -> int:
        """Resets the environments of a mask (n,), moves their robots, and writes their rows.

        `model_poses` has shape (n, 3 * models); the models are moved after the robots. Returns the
        first environment in which a scattered crowd has found no room, or -1.

        Raises:
            ValueError: an array does not fit, or a number is not finite. Nothing has changed.
        """
    def scatter(self, crowd: Crowd, keys: npt.NDArray[np.uint64], mask: BoolArray | None) -> None:
        """Lets a crowd draw its places at each reset, by a key for each environment (n,).

        The batch is of a world before `Crowd.scatter`.
        """
    def set_settings(self, values: FloatArray, mask: BoolArray | None) -> None:
        """Gives environments of a mask (n,) other values of `varied`: shape (n, varied).

        Masses follow their densities with the next reset.

        Raises:
            ValueError: an array does not fit, or a body cannot have its mass.
        """
    def move_robots(self, poses: FloatArray, mask: BoolArray | None) -> None:
        """Moves the robots of a mask (n * m,), and stops them. Writes no rows.

        Raises:
            ValueError: an array does not fit, or a number is not finite. Nothing has changed.
        """
    def save_state(self, row: int) -> bytes:
        """The state of an environment, as `World.save_state` makes it."""
    def load_states(
        self,
        mask: BoolArray | None,
        states: Sequence[bytes],
        walls: Sequence[Walls | None],
        chosen: IntArray,
        steps: IntArray,
        out: tuple[Any, ...],
    ) -> None:
        """Puts environments into saved states, and writes their rows. Releases the GIL.

        Args:
            mask: which environments, (n,); None: all.
            states: of `save_state`, here or of a world that was built in the same way.
            walls: of the first layer in each state, as for `set_walls`.
            chosen: index of the state of each environment, (n,).
            steps: that each environment has made in its state, (n,).
            out: as for the class.

        Raises:
            ValueError: an array does not fit, or a state is damaged or of another world. Nothing
                has changed.
        """
    def observe(self, out: tuple[Any, ...]) -> None:
        """Writes all rows."""
    def replace(self, row: int, world: World) -> None:
        """Replaces the initial world of an environment, for instance by one with other walls.

        The new one has made no step, and has the same bodies, drives and lidars; it is copied.
        """
    def set_walls(self, row: int, walls: Walls | None) -> None:
        """Lets an environment begin again with other walls in the first layer.

        With None, they are those of the world. Nothing changes if it has these already.

        Raises:
            ValueError: the world has no layer, or environments begin near walls. Nothing has
                changed.
        """
    def seed(
        self,
        owner: Crowd | Drive | Tricycle | Ackermann,
        keys: npt.NDArray[np.uint64],
        mask: BoolArray | None,
    ) -> None:
        """Begins other random numbers of a crowd or a drive, by a key for each environment (n,)."""
    def motions(
        self, bodies: Sequence[Body], mask: BoolArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """The poses and velocities of bodies: new arrays (n, bodies, 3), 0 outside of the mask.

        x, y [m] and yaw in [-pi, pi] [rad], and vx, vy [m/s] and omega [rad/s] of the body's
        origin, in the world's frame.
        """
    def set_velocities(
        self, bodies: Sequence[Body], velocities: FloatArray, mask: BoolArray | None
    ) -> None:
        """Sets the velocities of bodies: shape (n, 3 * bodies).

        Raises:
            ValueError: an array does not fit, or a number is not finite. Nothing has changed.
        """

class Body(_WithoutConstructor):
    """A handle of a body. Handles of the same body are equal."""

    @property
    def id(self) -> int:
        """Unique among all present and former bodies of its world. Never raises GoneError."""
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def alive(self) -> bool:
        """True if the body still exists. Never raises GoneError."""
    def remove(self) -> None:
        """Removes the body with its fixtures, joints, drives, tweens and lidars.

        Raises:
            Exception: raised by the contact listener for a contact that ends by the removal.
        """
    def add_circle(
        self,
        center: _PairLike,
        radius: float,
        *,
        density: float,
        friction: float = 0.0,
        restitution: float = 0.0,
        sensor: bool = False,
        collides: bool = True,
        visible: bool = True,
        layers: int = 0xFFFF,
    ) -> Fixture:
        """Adds a disc.

        Args:
            center: in the body's frame [m].
            radius: 1e-4 to 1e5 [m].
            density: 0, or 1e-6 or more [kg/m^2].
            friction: Box2D's coefficient, 0 or more.
            restitution: Box2D's coefficient, 0 or more.
            sensor: whether it reports contacts, but passes through everything.
            collides: whether it has contacts at all.
            visible: whether lidars see it.
            layers: bits of its collision layers.
        """
    def add_polygon(
        self,
        vertices: Sequence[_PairLike] | FloatArray,
        *,
        density: float,
        friction: float = 0.0,
        restitution: float = 0.0,
        sensor: bool = False,
        collides: bool = True,
        visible: bool = True,
        layers: int = 0xFFFF,
    ) -> Fixture:
        """Adds the convex hull of some vertices.

        Args:
            vertices: 3 to 8, in the body's frame [m].
            density: 0, or 1e-6 or more [kg/m^2].
            friction: Box2D's coefficient, 0 or more.
            restitution: Box2D's coefficient, 0 or more.
            sensor: whether it reports contacts, but passes through everything.
            collides: whether it has contacts at all.
            visible: whether lidars see it.
            layers: bits of its collision layers.
        """
    @property
    def fixtures(self) -> list[Fixture]:
        """Its fixtures, in the order in which they were added."""

    def fixture(self, index: int) -> Fixture:
        """One of its fixtures, without making the list of `fixtures`, which may have millions.

        Args:
            index: from 0, in the order of `fixtures`.

        Raises:
            IndexError: it has no such fixture.
        """
    @property
    def overlapping(self) -> list[Body]:
        """The other bodies that overlap this one, and that the solver would push out of it.

        The two fixtures collide, share a layer and are no sensors, and one of the bodies is
        dynamic. Shapes that touch overlap.
        """
    def add_revolute(
        self,
        other: Body,
        anchor: _PairLike,
        other_anchor: _PairLike,
        *,
        collide_connected: bool = False,
        limits: _PairLike | None = None,
    ) -> Joint:
        """Connects this body and another one by a hinge.

        Args:
            other: a body of the same world.
            anchor: the hinge, in this body's frame [m].
            other_anchor: the hinge, in the other body's frame [m].
            collide_connected: whether the two bodies collide with each other.
            limits: lower and upper limit of the other's angle minus this one's [rad].
        """
    def add_weld(
        self,
        other: Body,
        anchor: _PairLike,
        other_anchor: _PairLike,
        *,
        collide_connected: bool = False,
        angle: float = 0.0,
        frequency: float = 0.0,
        damping: float = 0.0,
    ) -> Joint:
        """Fixes the pose of another body relative to this one, rigidly or by a spring.

        Args:
            other: a body of the same world.
            anchor: the weld, in this body's frame [m].
            other_anchor: the weld, in the other body's frame [m].
            collide_connected: whether the two bodies collide with each other.
            angle: the other's angle minus this one's [rad].
            frequency: of the spring [Hz]; 0 is rigid.
            damping: damping ratio of the spring; 1 is critical.
        """
    def add_drive(
        self,
        linear_limits: _TripleLike = (0.0, 0.0, 0.0),
        angular_limits: _TripleLike = (0.0, 0.0, 0.0),
        actuators: _Actuators | None = None,
    ) -> Drive:
        """Adds a drive, which moves the body at commanded velocities.

        Limits are (acceleration, deceleration, velocity), 0 for no limit.

        Args:
            linear_limits: of the planar velocity [m/s^2, m/s^2, m/s].
            angular_limits: of the yaw rate [rad/s^2, rad/s^2, rad/s].
            actuators: (linear, angular, command_timeout, key, force): each axis (delay [s],
                time_constant [s], dead_band, noise); the timeout [s], 0 for none; the key of the
                noise; (max_force [N], max_torque [N m], friction), 0 for no limit. None: the body
                has the velocities of the commands at once.
        """
    def add_tricycle(
        self,
        front_wheel: Joint,
        rear_axle: _PairLike,
        max_steer_angle: float = 0.0,
        linear_limits: _TripleLike = (0.0, 0.0, 0.0),
        steering_limits: _TripleLike = (0.0, 0.0, 0.0),
        actuators: _Actuators | None = None,
    ) -> Tricycle:
        """Adds the drive of a tricycle, the front wheel of which is at the body's origin.

        Limits are (acceleration, deceleration, velocity), 0 for no limit.

        Args:
            front_wheel: a revolute joint of this body that holds the body of the front wheel. That
                body is rotated to show the steering angle.
            rear_axle: middle of the rear axle, in the body's frame [m].
            max_steer_angle: largest magnitude of the steering angle [rad]; 0 for no limit.
            linear_limits: of the front wheel's speed [m/s^2, m/s^2, m/s].
            steering_limits: of the steering rate [rad/s^2, rad/s^2, rad/s].
            actuators: as of `add_drive`; the angular axis is that of the steering angle.
        """
    def add_ackermann(
        self,
        wheelbase: float,
        max_steer_angle: float,
        *,
        wheels: Sequence[Joint] = (),
        linear_limits: _TripleLike = (0.0, 0.0, 0.0),
        jerk_limit: float = 0.0,
        steering_limits: _TripleLike = (0.0, 0.0, 0.0),
        single_track: Sequence[float] | None = None,
        actuators: _Actuators | None = None,
    ) -> Ackermann:
        """Adds the drive of a car, the rear axle of which has its middle at the body's origin.

        Limits are (acceleration, deceleration, velocity), 0 for no limit.

        Args:
            wheelbase: from the rear axle to the front axle [m].
            max_steer_angle: largest magnitude of the steering angle, below pi/2 [rad].
            wheels: revolute joints of this body, 2 at most, that hold the bodies of the steered
                wheels. These are rotated to show their angles.
            linear_limits: of the speed [m/s^2, m/s^2, m/s].
            jerk_limit: of the acceleration's change [m/s^3]; 0 for no limit.
            steering_limits: of the steering rate [rad/s^2, rad/s^2, rad/s].
            single_track: the seven numbers of a car with tyres that slip: mass [kg], moment of
                inertia [kg m^2], the centre of mass in front of the rear axle [m] and its height
                [m], the coefficient of friction, and the cornering stiffness of the front and of
                the rear axle [1/rad]; see ackermann_drive.hpp. None: no tyre slips.
            actuators: as of `add_tricycle`.
        """
    def add_tween(
        self, delta: _TripleLike, duration: float, mode: str = "yoyo", easing: str = "linear"
    ) -> Tween:
        """Adds a tween, which moves the body along a straight line as a function of time.

        Args:
            delta: the end minus the present pose, in the world's frame [m, m, rad].
            duration: from the start to the end [s].
            mode: one of TWEEN_MODES.
            easing: one of EASINGS.
        """
    def add_drift(
        self,
        key: int,
        translation: _PairLike = ...,
        rotation: _PairLike = ...,
        per_second: _TripleLike = ...,
        biases: _TripleLike = ...,
        period: float = 0.0,
    ) -> Drift:
        """Adds a drift: measures the body's motions with errors, and adds them up to its pose.

        The first estimate is the truth. Errors add up in steps alone: if the body is moved between
        two steps, the estimate moves with it.

        Args:
            key: of the random numbers, from 0 to 2^64 - 1. Equal keys give equal errors.
            translation: variances along the direction of travel per metre driven [m^2/m], and
                along the body's x axis per angle turned [m^2/rad]; 0 or more, as the others.
            rotation: of the heading per metre [rad^2/m] and per angle [rad^2/rad].
            per_second: of x, y and yaw in the body's frame [m^2/s, m^2/s, rad^2/s], also at rest.
            biases: standard deviations of what the wheels deviate by in this run: their radius and
                their track width, both relative, and the curvature of a straight path [rad/m].
            period: between two updates, over which the measured velocity is a mean [s].
        """
    def add_lidar(
        self,
        fan: BeamFan,
        pose: _TripleLike,
        range: float,
        layers: int = 0xFFFF,
        reflectance_layers: int = 0,
        range_min: float = 0.0,
        ignored: Sequence[Body] = (),
    ) -> Lidar:
        """Adds a lidar.

        Args:
            fan: directions of its beams.
            pose: in the body's frame [m, m, rad].
            range: largest distance that is measured [m].
            layers: bits of the collision layers that are seen.
            reflectance_layers: bits of those layers that return an intensity of 255.
            range_min: what is nearer returns -infinity [m].
            ignored: bodies that it does not see.
        """
    @property
    def pose(self) -> _Triple:
        """Pose of its origin in the world [m, m, rad]. The yaw is not wrapped to [-pi, pi].

        Setting it wakes the body, and keeps its velocity. Not possible in a contact listener.
        """
    @pose.setter
    def pose(self, pose: _TripleLike) -> None: ...
    @property
    def velocity(self) -> _Triple:
        """Velocity of its origin, in the world's frame [m/s, m/s, rad/s]."""
    @velocity.setter
    def velocity(self, velocity: _TripleLike) -> None: ...
    @property
    def local_velocity(self) -> _Triple:
        """Velocity of its origin, in its own frame [m/s, m/s, rad/s]."""
    def read_motion(self, pose: FloatArray, local_velocity: FloatArray) -> None:
        """Writes the pose, with its yaw in [-pi, pi], and the local velocity into arrays.

        Args:
            pose: x, y [m] and yaw [rad] in the world, shape (3,).
            local_velocity: see `local_velocity`, shape (3,).
        """
    def velocity_at(self, point: _PairLike) -> _Pair:
        """Velocity of the body at a point, in the world's frame [m/s].

        Args:
            point: in the world [m].
        """
    def halt(self) -> None:
        """Sets the velocities of the body and its drives, and their commands, to zero."""
    def apply_force(self, force: _PairLike, point: _PairLike | None = None) -> None:
        """Applies a force during the next step.

        A force applied by a contact listener acts in the step after the present one.

        Args:
            force: in the world's frame [N].
            point: in the world [m]; None is the centre of mass.
        """
    def apply_torque(self, torque: float) -> None:
        """Applies a torque during the next step; by a contact listener, during the one after.

        Args:
            torque: counter-clockwise [N m].
        """
    def apply_linear_impulse(self, impulse: _PairLike, point: _PairLike | None = None) -> None:
        """Changes the momentum immediately.

        Args:
            impulse: in the world's frame [N s].
            point: in the world [m]; None is the centre of mass.
        """
    def apply_angular_impulse(self, impulse: float) -> None:
        """Changes the angular momentum immediately.

        Args:
            impulse: counter-clockwise [N m s].
        """
    def world_point(self, point: _PairLike) -> _Pair:
        """A point of the body's frame, in the world's frame.

        Args:
            point: in the body's frame [m].
        """
    def local_point(self, point: _PairLike) -> _Pair:
        """A point of the world, in the body's frame.

        Args:
            point: in the world's frame [m].
        """
    def world_vector(self, vector: _PairLike) -> _Pair:
        """A vector of the body's frame, in the world's frame.

        Args:
            vector: in the body's frame.
        """
    def local_vector(self, vector: _PairLike) -> _Pair:
        """A vector of the world's frame, in the body's frame.

        Args:
            vector: in the world's frame.
        """
    @property
    def type(self) -> str:
        """Static, kinematic or dynamic, in lower case."""
    @property
    def mass(self) -> float:
        """Mass [kg]; 0 unless dynamic."""
    @property
    def inertia(self) -> float:
        """Moment of inertia about the centre of mass [kg m^2]; 0 unless dynamic."""
    @property
    def center(self) -> _Pair:
        """Centre of mass in the world [m]."""
    @property
    def local_center(self) -> _Pair:
        """Centre of mass in the body's frame [m]."""
    def set_mass(
        self,
        mass: float,
        *,
        inertia: float | None = None,
        local_center: _PairLike | None = None,
    ) -> None:
        """Gives a dynamic body another mass than that of its fixtures.

        It is in saved states. `reset_mass`, a further fixture with a density, another shape of one
        (`Model.set_footprint`) and a reset of the world end it. The velocity of the body's origin
        stays. A contact listener's mass counts from the end of the step on.

        Args:
            mass: 1e-12 to 1e12 [kg].
            inertia: about the centre of mass, 1e-24 to 1e24 [kg m^2]; None: it grows with the mass.
            local_center: centre of mass in the body's frame [m]; None leaves it where it is.

        Raises:
            ValueError: the body is not dynamic, or cannot have this mass; nothing has changed.
        """
    def reset_mass(self) -> None:
        """Gives a dynamic body the mass of its fixtures, as it had before `set_mass`."""
    @property
    def awake(self) -> bool:
        """True if Box2D simulates it; a body at rest falls asleep."""
    def listen_to_contacts(self, events: int) -> None:
        """Chooses the events of its contacts that the world's contact listener receives.

        Args:
            events: a bitwise or of BEGIN_CONTACT, END_CONTACT, PRE_SOLVE and POST_SOLVE, or 0 for
                none. A contact's event is reported if either of its two bodies has chosen it.
        """

class RelativePoses(metaclass=_Metaclass):
    """Reads the poses of bodies in the frame of another body, or in the world, all in one call.

    Args:
        reference: the body that has the frame; None: the world.
        bodies: n bodies of the same world.
        drift: of the only body, in the world: its pose and velocity are the measured ones.

    Raises:
        ValueError: the bodies are of several worlds, or the drift is not of one body in the world.
    """

    def __init__(
        self, reference: Body | None, bodies: Sequence[Body], drift: Drift | None = None
    ) -> None: ...
    def __iter__(self) -> Iterator[_Triple]:
        """Iterates over the poses of `read`."""

    def read(self) -> list[_Triple]:
        """Returns n poses [m, m, rad].

        A yaw in the world is in [-pi, pi]; one in the frame of a body is the difference of two
        such yaws.
        """

def set_stamp_offset(nanoseconds: int) -> None:
    """Sets the difference between stamps and simulated time [ns], of all messages written here."""

class BodyMessage(metaclass=_Metaclass):
    """The bytes of a message with present poses and velocities of bodies among constants.

    Numbers are little-endian, as ROS sends them. A header begins with its sequence number, seconds
    and nanoseconds (uint32). A pose is a position and a quaternion, a twist the linear and the
    angular velocity (double).

    Args:
        data: the message with any numbers.
        poses: of n bodies.
        fields: of each body, the offsets of its header, pose and twist; the last two may be None.
        twist_in_local_frame: whether twists are in the frame of the body instead of the world.
        is_numbered: whether sequence numbers count the messages, from 1; otherwise they are 0.

    Raises:
        IndexError: a field is not within the data.
        ValueError: there are not n fields.
    """

    def __init__(
        self,
        data: bytes,
        poses: RelativePoses,
        fields: Sequence[tuple[int, int | None, int | None]],
        twist_in_local_frame: bool = True,
        is_numbered: bool = True,
    ) -> None: ...
    def data(self, nanoseconds: int) -> bytes:
        """The message of a time.

        Args:
            nanoseconds: simulated time [ns].

        Raises:
            GoneError: a body was removed.
        """

class SubscriberQueue(metaclass=_Metaclass):
    """Messages on their way to a subscriber's socket, as bytes with their lengths.

    Nothing waits for the socket. What it does not take is sent by a thread of the core when it has
    room.

    Args:
        socket: its file descriptor; the queue has a duplicate of it.
        limit: number of messages that wait while the socket is full; the oldest are dropped. 0 is
            any number.
        patience: real time for which more of them may wait [s].

    Raises:
        RuntimeError: there is no such descriptor, or there are too many.
    """

    def __init__(self, socket: int, limit: int, patience: float) -> None: ...
    def send(self, data: bytes) -> bool:
        """Adds a message, and sends all that wait. Returns False if the connection has failed."""

    def close(self) -> None:
        """Forgets the messages, and closes the duplicate: the connection counts as failed."""

    @property
    def error(self) -> int:
        """The errno with which the connection has failed, or 0."""
    @property
    def bytes_sent(self) -> int:
        """Number of bytes sent."""
    @property
    def messages_sent(self) -> int:
        """Number of messages sent as a whole."""

class Outbox(metaclass=_Metaclass):
    """The subscribers with messages that wait, so that each of them gets several in one call.

    Args:
        period: real time that a message is to wait at most [s].
        most: number of messages of a subscriber that are to wait at most.
    """

    def __init__(self, period: float, most: int) -> None: ...
    def add(self, queue: SubscriberQueue, data: bytes) -> bool:
        """Adds a message to those of a subscriber. Returns False if the connection has failed."""

    def is_empty(self) -> bool:
        """True if no message waits."""
    def is_due(self) -> bool:
        """True if a message has waited for the period, or a subscriber has too many."""
    def send(self) -> bool:
        """Sends what waits, without Python's lock. Returns False if a connection has failed."""

class TransformList(metaclass=_Metaclass):
    """The serialized transforms of a step."""

    def __init__(self) -> None: ...
    def add(self, count: int, data: bytes) -> None:
        """Appends `count` transforms."""

    def take(self) -> bytes:
        """Returns and forgets them, as a tf2_msgs/TFMessage; empty if there are none."""

class StepMessage(metaclass=_Metaclass):
    """A message that the core writes at each step; see `StepMessages`.

    Args:
        message: the message to write.
        outbox: outbox that holds the message until it is sent.
        queues: queues of the subscribers that get the message.
        transforms: if the message is transforms, the list that they are added to.
    """

    @overload
    def __init__(
        self, message: BodyMessage, outbox: Outbox, queues: Sequence[SubscriberQueue]
    ) -> None: ...
    @overload
    def __init__(self, message: BodyMessage, transforms: TransformList) -> None: ...

class StepMessages(metaclass=_Metaclass):
    """Messages that are written at each step, in a fixed order, by one call of Python."""

    def __init__(self) -> None: ...
    def add(self, order: int, message: StepMessage) -> None:
        """Adds a message. To be called in the order of the messages."""

    def write(self, nanoseconds: int) -> None:
        """Writes all messages of a time [ns].

        Raises:
            GoneError: a body was removed.
        """

    def begin(self, nanoseconds: int) -> None:
        """Begins a step at a time [ns], of which `write_until` writes the messages."""

    def write_until(self, order: int) -> None:
        """Writes the messages before a place in the order that are not written yet.

        Raises:
            GoneError: a body was removed.
        """

class BodyGroup(metaclass=_Metaclass):
    """Reads the poses and velocities of bodies, all in one call.

    Args:
        bodies: n bodies of the same world.
    """

    def __init__(self, bodies: Sequence[Body]) -> None: ...
    def __len__(self) -> int:
        """The number of bodies, n."""
    def poses(self) -> FloatArray:
        """A new array of shape (n, 3): x, y [m] and yaw in [-pi, pi] [rad] in the world."""
    def velocities(self) -> FloatArray:
        """A new array of shape (n, 3): vx, vy [m/s] and omega [rad/s], in the world's frame."""
    def clearance(self, limit: float) -> float:
        """The distance from the nearest wall or other body that one of them can touch [m].

        Only footprints that collide, are no sensors and share a layer count. The distance of
        overlapping ones is 0.

        Args:
            limit: range of the search, and the result if nothing is nearer [m].
        """
    def record_collisions(self) -> None:
        """Records the collisions of the bodies from now on."""
    def last_collisions(self) -> list[_Collision]:
        """The recorded collisions of the last step, also those that ended in it.

        Returns:
            For each a number, which increases from one begin to the next; the two fixtures; whether
            one is a sensor; up to two points in the world [m]; the unit vector from the first
            fixture to the second in the world's frame; and the force at each point [N], the
            mean of the step: 0 while both bodies rest. With a sensor there are no points, and the
            vector is zero. Solid contacts that are disabled are no collisions.
        """
    def present_collisions(self) -> list[_Collision]:
        """The recorded collisions that go on, as in `last_collisions`, without forces."""
    def restore_collision(
        self,
        number: int,
        fixture_a: Fixture,
        fixture_b: Fixture,
        has_sensor: bool,
        points: Sequence[_Pair],
        normal: _Pair,
    ) -> None:
        """Restores one of `present_collisions`; `restore_state` does not."""

class Fixture(_WithoutConstructor):
    """A handle of a body's shape or a layer's wall. Handles of the same one are equal."""

    @property
    def body(self) -> Body:
        """The body that it belongs to. Never raises GoneError."""
    @property
    def index(self) -> int:
        """Its index in `Body.fixtures`. Never raises GoneError."""
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def density(self) -> float:
        """Density [kg/m^2]."""
    @property
    def friction(self) -> float:
        """Coefficient of friction. When it is set, existing contacts keep theirs."""
    @friction.setter
    def friction(self, friction: float) -> None: ...
    @property
    def restitution(self) -> float:
        """Coefficient of restitution. When it is set, existing contacts keep theirs."""
    @restitution.setter
    def restitution(self, restitution: float) -> None: ...
    @property
    def sensor(self) -> bool:
        """True if it reports contacts, but passes through everything."""
    @property
    def collides(self) -> bool:
        """True if it has contacts at all."""
    @property
    def visible(self) -> bool:
        """True if lidars see it; cannot be set for walls."""
    @visible.setter
    def visible(self, visible: bool) -> None: ...
    @property
    def seen_radius(self) -> float:
        """Radius of the bounding circle as lidars see it [m]: its own, until it is set.

        Can be set for circles, to 1e-4 to 1e5 m; a new shape ends that. Bodies touch its own.
        """
    @seen_radius.setter
    def seen_radius(self, radius: float) -> None: ...
    @property
    def layers(self) -> int:
        """Bits of its collision layers."""
    def test_point(self, point: _PairLike) -> bool:
        """True if a point is within the shape; always False for a wall.

        Args:
            point: in the world [m].
        """
    def set_circle(self, center: _PairLike, radius: float, *, layers: int | None = None) -> None:
        """Replaces the shape by a disc. For a footprint of a model, use `Model.set_footprint`.

        The fixture keeps its density, friction and restitution, and the body's mass follows. Its
        contacts end; the next step finds the new ones. Not possible in a contact listener.

        Args:
            center: in the body's frame [m].
            radius: 1e-4 to 1e5 [m].
            layers: bits of its collision layers; None leaves them as they are.

        Raises:
            ValueError: the body cannot have this shape, or this is a wall; nothing has changed.
            Exception: raised by the contact listener for a contact that ends.
        """
    def set_polygon(
        self, vertices: Sequence[_PairLike] | FloatArray, *, layers: int | None = None
    ) -> None:
        """Replaces the shape by the convex hull of some vertices; see `set_circle`.

        Args:
            vertices: 3 to 8, in the body's frame [m].
            layers: bits of its collision layers; None leaves them as they are.
        """

class Joint(_WithoutConstructor):
    """A handle of a joint."""

    @property
    def alive(self) -> bool:
        """True if the joint still exists: until one of its bodies is removed."""
    @property
    def angle(self) -> float:
        """Angle of the second body minus that of the first, in [-pi, pi] [rad].

        Of a weld, minus the weld's own angle.
        """
    @property
    def speed(self) -> float:
        """The rate of the angle [rad/s]."""
    @property
    def limits(self) -> _Pair | None:
        """Lower and upper limit of the angle [rad], in single precision; None: it turns freely.

        Can be set. The whole rotations of a joint that was free do not count then: its angle is
        `angle`, or, if the limits do not contain that, the one nearest to their middle among those
        that look alike. Limits and `motor` are in saved states, and a reset of the world makes them
        what the file says. What a contact listener sets counts from the end of the step on.

        Raises:
            ValueError: the joint is a weld, which has neither, or the value is not finite, or the
                lower limit above the upper one; nothing has changed.
        """
    @limits.setter
    def limits(self, value: _PairLike | None) -> None: ...
    @property
    def motor(self) -> _Pair | None:
        """Speed to reach [rad/s], and the greatest torque for it [N m], 0 or more; None: no motor.

        Can be set, see `limits`. A speed of 0 brakes.
        """
    @motor.setter
    def motor(self, value: _PairLike | None) -> None: ...
    @property
    def motor_torque(self) -> float:
        """The torque that the motor had in the last step [N m], on the second body."""

class Drive(_WithoutConstructor):
    """A handle of a body's drive. Velocities are those of the body's origin, in its frame."""

    def command(self, vx: float, vy: float, omega: float) -> None:
        """Sets the velocity to reach.

        Args:
            vx: forwards [m/s].
            vy: to the left [m/s].
            omega: counter-clockwise [rad/s].
        """
    @property
    def target(self) -> _Triple:
        """The commanded velocity [m/s, m/s, rad/s]."""
    @property
    def velocity(self) -> _Triple:
        """The present velocity, which approaches the target within the limits [m/s, m/s, rad/s]."""

class Tricycle(_WithoutConstructor):
    """A handle of a tricycle's drive."""

    def command(self, speed: float, steer_angle: float) -> None:
        """Sets the motion of the front wheel to reach.

        Args:
            speed: [m/s].
            steer_angle: positive to the left [rad].
        """
    @property
    def speed(self) -> float:
        """Present speed of the front wheel [m/s]."""
    @property
    def steer_angle(self) -> float:
        """Present angle of the front wheel, positive to the left [rad]."""

class Ackermann(_WithoutConstructor):
    """A handle of a car's drive.

    The speed is that of the rear axle or, if tyres slip, of the centre of mass.
    """

    def command(self, speed: float, steer_angle: float) -> None:
        """Sets the motion to reach.

        Args:
            speed: [m/s].
            steer_angle: of a wheel in the middle of the front axle, positive to the left [rad].
        """
    def command_within(
        self,
        speed: float,
        steer_angle: float,
        steering_rate: float,
        acceleration: float,
        jerk: float,
    ) -> None:
        """Sets the motion to reach, within limits of this command; 0 is none.

        Args:
            speed: [m/s].
            steer_angle: positive to the left [rad].
            steering_rate: the fastest [rad/s].
            acceleration: the greatest, of either sign [m/s^2].
            jerk: the greatest [m/s^3].
        """
    @property
    def speed(self) -> float:
        """Present speed [m/s]."""
    @property
    def steer_angle(self) -> float:
        """Present steering angle, positive to the left [rad]."""
    @property
    def slip_angle(self) -> float:
        """Angle from the heading to the velocity of the centre of mass [rad]; 0 without slip."""

TWEEN_MODES: tuple[str, ...]
"""Names of the modes of tweens."""
EASINGS: tuple[str, ...]
"""Names of the easings of tweens."""

class Tween(_WithoutConstructor):
    """A handle of a body's tween."""

    def trigger(self, forward: bool) -> None:
        """Starts a motion in mode trigger; in other modes, it has no effect.

        Args:
            forward: whether it moves towards the end, or back towards the start.
        """
    @property
    def progress(self) -> float:
        """Elapsed fraction of the duration, 0 at the start and 1 at the end; before easing."""

class Crowd(_WithoutConstructor):
    """A handle of a crowd: people who walk between goals, and give way to what is around them."""

    def add_person(
        self,
        body: Body,
        *,
        goals: Sequence[_PairLike],
        radius: float,
        speed: float,
        legs: Sequence[Body] = (),
        circle: Body | None = None,
        leg_offset: float = 0.0,
        walk_ratio: float = 0.0,
        leg_radii: _PairLike = ...,
        attention: tuple[bool, float, float, float] = ...,
        group: int = -1,
        area: tuple[_Pair, _Pair] | None = None,
        stands: bool = False,
        recording: Sequence[FloatArray] = (),
    ) -> None:
        """Adds a person, on the way to the first goal. It leaves when one of its bodies is removed.

        Args:
            body: walks, and turns where it goes.
            goals: visited in turn [m]; with a single one, the person stays there.
            radius: of the person [m].
            speed: the desired one [m/s].
            legs: the left and the right one, or none.
            circle: goes along with the body.
            leg_offset: distance of a leg from the middle [m].
            walk_ratio: a step's length by the steps per second [m s].
            leg_radii: of a leg's first footprint as lidars see it, on the floor and in the middle
                of its swing [m]; if they are equal, it stays as it is.
            attention: whether it sees robots, the probability that it gives way to them in an
                encounter, its reaction time [s] and its field of view [rad].
            group: the people of a group keep together; -1: none.
            area: lower and upper corner of a rectangle in which goals are drawn [m].
            stands: at the place in the area at which `scatter` puts it.
            recording: walks that it follows instead of going to goals, one after the other: rows of
                time [s], x and y [m]. Between two of them it is away, beyond `AWAY`.
        """
    def follow(self, person: int, point: _PairLike, velocity: _PairLike) -> None:
        """Lets a person follow an agent from now on, instead of walking to its goals.

        The agent walks on for a second. The person jumps to it if it is farther away than 1 m.

        Args:
            person: its number, in the order in which they were added.
            point: where the agent is [m].
            velocity: of the agent [m/s].
        """
    def remove(self) -> None:
        """Removes the crowd. The bodies of its people stay, and move like others."""
    def clearances(self) -> list[_Triple]:
        """The distances of each person's middle from the nearest wall, body and other person [m].

        Infinite if there is none, or no wall within the reach of the forces.
        """
    def scatter(self) -> None:
        """Puts people with an area at drawn places in it: one for which none is found stays.

        Those with a recording are put where it begins.
        """

AWAY: float
"""People of a crowd who are away have larger coordinates [m]."""

def orca_velocity(
    velocity: _PairLike,
    preferred: _PairLike,
    neighbors: FloatArray,
    walls: FloatArray,
    *,
    most: float,
    horizon: float,
    wall_horizon: float,
    dt: float,
) -> _Pair:
    """The velocity [m/s] nearest to the preferred one that avoids collisions (ORCA).

    J. van den Berg et al., "Reciprocal n-body collision avoidance", Robotics Research, 2011.

    Args:
        velocity: the present one [m/s].
        preferred: [m/s].
        neighbors: offset from the agent [m], velocity [m/s], the sum of both radii [m] and the
            agent's share of the avoidance, commonly 0.5; shape (n, 6), contiguous.
        walls: distance of the nearest point less the agent's radius [m], and the direction away
            from it, of length 1; shape (n, 3), contiguous.
        most: the largest speed [m/s].
        horizon: time without collisions with neighbours [s].
        wall_horizon: time without collisions with walls [s].
        dt: after which agents that overlap are to be apart [s].

    Raises:
        ValueError: an array has another shape, or a time is not above zero.
    """

class Drift(_WithoutConstructor):
    """A handle of a body's drift: the motion that it measures, and the pose that adds up."""

    @property
    def pose(self) -> _Triple:
        """The present estimate in the world [m, m, rad], the yaw within [-pi, pi]."""
    @property
    def velocity(self) -> _Triple:
        """The measured velocity in the body's frame [m/s, m/s, rad/s]: the mean of an update."""

class GoalObserver(metaclass=_Metaclass):
    """Makes observations of robots that drive to goals; docs/learning.md describes them.

    Args:
        beams: number of the lidar's beams.
        max_range: of the lidar [m].
        velocity_limits: by which the velocities forwards, to the left and turning are divided;
            0 leaves the part out.
    """

    def __init__(self, beams: int, max_range: float, velocity_limits: Sequence[float]) -> None: ...
    def observe(
        self, ranges: Float32Array, poses: FloatArray, velocities: FloatArray, goals: FloatArray
    ) -> Float32Array:
        """Flat observations: a new array of shape (n, beams + 3 + parts of the velocity).

        A row does not depend on the other rows. Releases the GIL.

        Args:
            ranges: [m], shape (n, beams); +inf for no return.
            poses: x, y [m] and yaw [rad], shape (n, 3).
            velocities: in the robots' frames, shape (n, 3): forwards, to the left, turning.
            goals: x, y [m], shape (n, 2).
        """

class LinesOfSight(metaclass=_Metaclass):
    """Tells which straight lines are blocked by walls.

    Args:
        walls: x1, y1, x2, y2 [m], shape (m, 4).
    """

    def __init__(self, walls: Segments) -> None: ...
    def blocked(self, lines: FloatArray) -> BoolArray:
        """True for each line that a wall crosses: a new array of shape (n,). Releases the GIL.

        Args:
            lines: x1, y1, x2, y2 [m], shape (n, 4); a line that is not finite is not blocked.
        """

def blocked_lines(walls: Sequence[LinesOfSight], which: IntArray, lines: FloatArray) -> BoolArray:
    """As `LinesOfSight.blocked`, each line by walls of its own. Releases the GIL.

    Args:
        walls: of all lines.
        which: the index of each line's walls, shape (n,); -1 for none.
        lines: as for `LinesOfSight.blocked`.

    Raises:
        ValueError: there are no walls of an index, or an array has a wrong shape.
    """

def normal_rows(keys: npt.NDArray[np.uint64], count: int) -> FloatArray:
    """Normally distributed random numbers: a new array of shape (n, count).

    Args:
        keys: equal ones give equal rows, shape (n,).
        count: number of numbers in a row.
    """

def lower_to_walls(
    squares: FloatArray, walls: Segments, reach: float, corner: _PairLike, side: float
) -> None:
    """Lowers numbers of the squares of a floor to their squared distances from walls, in place.

    Only near the walls: at least within `reach` of the rectangles around them. Releases the GIL.

    Args:
        squares: shape (rows, columns): a row has the same y [m^2].
        walls: shape (n, 4), x1, y1, x2, y2 [m].
        reach: [m].
        corner: x, y of the first square's corner [m].
        side: of a square [m].
    """

def connected(free: BoolArray, start: tuple[int, int] | None) -> BoolArray:
    """The free squares that are connected with one through shared sides: a new array.

    Args:
        free: shape (rows, columns).
        start: row and column of that square. If it is not free, there are none. With None, they are
            the largest part that is connected.

    Raises:
        ValueError: the start is outside.
    """

class FloorSquares(metaclass=_Metaclass):
    """Some squares of a floor, and random places on them.

    Args:
        squares: which they are, shape (rows, columns): a row has the same y.
        corner: x, y of the corner of the first square [m].
        side: of a square [m].
    """

    def __init__(self, squares: BoolArray, corner: _PairLike, side: float) -> None: ...
    def __len__(self) -> int:
        """The number of squares."""
    def __contains__(self, point: _PairLike) -> bool:
        """True if a point is in one of the squares."""
    def crop(self, poses: FloatArray, cells: int) -> BoolArray:
        """True for the places around robots that are in a square: a new array (n, cells²).

        The places are the middles of squares of the same size in the robot's frame, the robot in
        the middle: rows from behind to ahead of it, each from its right to its left.

        Args:
            poses: x, y [m] and yaw [rad], shape (n, 3).
            cells: number of squares along each side.

        Raises:
            ValueError: an argument is wrong.
        """
    def draw(self, rng: np.random.Generator) -> _Pair:
        """A random point in a square: x, y [m].

        Draws the same as `rng.integers(len(self))` and `rng.random(2)`.

        Args:
            rng: generator of NumPy to draw from.

        Raises:
            ValueError: there is no square.
        """
    def draw_clear(
        self,
        rng: np.random.Generator,
        discs: Sequence[_Triple],
        radius: float,
        distance: float,
        count: int,
        tries: int,
    ) -> list[_Triple | None]:
        """Poses of discs, one after the other: x, y and yaw [m, m, rad].

        Each is at the first of several points of `draw` that is clear of the others and of those
        before it, and has a random heading.

        Args:
            rng: generator of NumPy to draw from.
            discs: the others: x, y and radius [m].
            radius: of the discs [m].
            distance: of their middles from the edges of others [m].
            count: number of poses.
            tries: number of points after which a disc has no place: None.

        Raises:
            ValueError: there is no square.
        """
    def draw_ends(
        self,
        rng: np.random.Generator,
        start: _PairLike | None,
        goal: _PairLike | None,
        distances: _PairLike,
        radius: float,
        at_starts: Sequence[_Triple],
        at_goals: Sequence[_Triple],
        tries: int,
    ) -> tuple[_Triple, _Pair] | None:
        """A random pose in these squares, and a goal: x, y and yaw, and x, y [m, m, rad].

        Args:
            rng: generator of NumPy to draw from.
            start: one that is given, and is not checked, or None.
            goal: the same for the goal.
            distances: the least and the largest distance of the two [m].
            radius: of a disc that must not overlap others [m].
            at_starts: those at the start: x, y and radius [m].
            at_goals: those at the goal.
            tries: number of tries after which it ends with None.

        Raises:
            ValueError: there is no square.
        """

class RangeNoise(metaclass=_Metaclass):
    """Gaussian noise of a lidar's ranges, different at each time.

    It depends on the key, the time and the beam alone: a scan made twice has the same noise.

    Args:
        key: from the plugin's random numbers: `int(self.rng.integers(2**63))`.
        std_dev: its standard deviation [m], 0 or more.
        max_range: of the lidar [m].
        min_range: of the lidar [m].
    """

    def __init__(
        self, key: int, std_dev: float, max_range: float, min_range: float = 0.0
    ) -> None: ...
    @property
    def key(self) -> int:
        """The key, from 0 to 2^64 - 1."""
    @property
    def settings(self) -> list[float]:
        """The standard deviation, the greatest and the least range [m]."""
    def __call__(self, ranges: Float32Array, nanoseconds: int) -> Float32Array:
        """Adds the noise at a time to ranges; returns a new array.

        Ranges stay within [min_range, max_range]; infinite ones stay.

        Args:
            ranges: of one scan [m], shape (n,).
            nanoseconds: the time of the scan [ns].
        """
    def add_to_rows(
        self,
        ranges: Float32Array,
        keys: npt.NDArray[np.uint64],
        nanoseconds: IntArray,
        mask: BoolArray | None,
        settings: FloatArray | None = None,
    ) -> None:
        """Adds noise to the ranges of several scans, in place. Releases the GIL.

        The noise's own key is not used.

        Args:
            ranges: shape (n, beams) [m].
            keys: a key for each scan, shape (n,).
            nanoseconds: the time of each scan [ns], shape (n,).
            mask: of the scans that get noise, shape (n,); None is all.
            settings: as `settings`, of each scan, shape (n, 3); None: those of the noise.
        """

class BeamFan(metaclass=_Metaclass):
    """The directions of a lidar's beams, in its frame.

    Args:
        angle_min: of the first beam [rad].
        increment: from one beam to the next, counter-clockwise [rad]; negative for clockwise.
        count: number of beams, 1 or more.
    """

    def __init__(self, angle_min: float, increment: float, count: int) -> None: ...
    def __len__(self) -> int:
        """Number of beams."""

class Lidar(_WithoutConstructor):
    """A handle of a lidar on a body."""

    def expect_scan(self) -> None:
        """Announces a call of `scan`.

        The first `scan` of any lidar of the world computes all announced scans, in parallel on all
        processor cores; the other calls return those results.
        """
    def scan(self) -> tuple[Float32Array, Float32Array]:
        """Scans the present world. Releases the GIL.

        Returns:
            Ranges [m] and intensities of n beams, shape (n,) each, as `World.scan` does; but no
            intensities, shape (0,), if it has no reflectance layers. Each call returns new arrays.
        """
    def ranges(self) -> Float32Array:
        """The ranges of `scan` alone, a new array in each call. Releases the GIL."""

BEGIN_CONTACT: int
"""Event: two fixtures begin to touch."""
END_CONTACT: int
"""Event: they cease to touch, or one of the bodies is removed."""
PRE_SOLVE: int
"""Event: in each step before the solver, while they touch; not with a sensor."""
POST_SOLVE: int
"""Event: in each step after the solver, while they touch; not with a sensor."""

class Contact(_WithoutConstructor):
    """A contact of two fixtures, at one of its events.

    Valid only during the call of the listener; after that its properties and methods raise
    GoneError, except `fixture_a` and `fixture_b`. It may be kept as a key: contacts of the same two
    fixtures are equal.
    """

    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def fixture_a(self) -> Fixture:
        """One of the two fixtures."""
    @property
    def fixture_b(self) -> Fixture:
        """The other fixture."""
    @property
    def touching(self) -> bool:
        """True if the two touch."""
    @property
    def enabled(self) -> bool:
        """True if the two push each other apart in this step; False with a sensor."""
    def set_enabled(self, enabled: bool) -> None:
        """At PRE_SOLVE: sets whether the two push each other apart in this step.

        Args:
            enabled: False lets them pass through each other.

        Raises:
            RuntimeError: the event is not PRE_SOLVE.
        """
    @property
    def points(self) -> list[_Pair]:
        """Up to two points in the world where they touch [m]; none with a sensor."""
    @property
    def normal(self) -> _Pair:
        """Unit vector from a to b in the world's frame; zero with a sensor."""
    @property
    def friction(self) -> float:
        """Coefficient of friction of this contact."""
    @friction.setter
    def friction(self, friction: float) -> None: ...
    @property
    def restitution(self) -> float:
        """Coefficient of restitution of this contact."""
    @restitution.setter
    def restitution(self, restitution: float) -> None: ...
    @property
    def tangent_speed(self) -> float:
        """Speed of the surface itself, as of a conveyor belt [m/s]."""
    @tangent_speed.setter
    def tangent_speed(self, tangent_speed: float) -> None: ...

class ContactImpulse(_WithoutConstructor):
    """The solver's impulses at the points of a contact, one for each point."""

    @property
    def normal_impulses(self) -> list[float]:
        """Along the normal [N s]."""
    @property
    def tangent_impulses(self) -> list[float]:
        """Across the normal [N s]."""

class Manifold(ContactImpulse):
    """The points of a contact in the previous step, with their impulses."""

    @property
    def local_points(self) -> list[_Pair]:
        """In the frame of the reference body that Box2D chose [m]; see b2Manifold."""

__version__: str
"""The version in flatland_server's package.xml when this was built."""

supports_numpy_2: bool
"""True if the core was built with a pybind11 that supports NumPy 2, from 2.12 on.

Otherwise it cannot be imported with NumPy 2: scans would be wrong.
"""

def box2d_reads_clock() -> bool:
    """True if Box2D reads the clock while it steps, which makes small worlds slower.

    It does not, unless another module of this process has loaded a shared libbox2d before, or this
    was linked so that it prefers its own timer; the results are the same. See box2d_timer.cpp.
    """

class PriorityGuard(metaclass=_Metaclass):
    """Takes real-time priority from the thread that creates it, if that computes for too long.

    It then also runs the handler that the signal had before. Linux only; one per process.
    """

    def __init__(self, signal: int) -> None:
        """Installs the handler of `signal`, which the thread gets when its CPU time is used up.

        Raises:
            RuntimeError: the system refuses it.
        """

    def arm(self, seconds: float) -> None:
        """Limits the thread's CPU time from now on [s]."""

    def disarm(self) -> None:
        """Removes the limit."""

    @property
    def has_fired(self) -> bool:
        """True if the thread has used up its time."""
