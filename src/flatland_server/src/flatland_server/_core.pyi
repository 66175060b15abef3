"""Flatland's physics and ray casting on Box2D; see include/flatland_server/world.hpp.

Using a handle whose object was deleted raises GoneError; a value that Box2D could not digest raises
ValueError; using the world while another thread does raises RuntimeError.
"""

from typing import Callable, Sequence, overload

from flatland_server.arrays import Float32Array, Segments

_Pair = tuple[float, float]
_Triple = tuple[float, float, float]

class GoneError(ReferenceError): ...

class BeamFan:
    def __init__(self, angle_min: float, increment: float, count: int) -> None: ...
    def __len__(self) -> int: ...

class Lidar:
    """A lidar on a body; it goes with the body."""

    def expect_scan(self) -> None:
        """Says that `World.scan` will be asked for it soon.

        All that are expected scan together, on all processor cores, when the first is asked for.
        """

class World:
    def __init__(self, velocity_iterations: int = 10, position_iterations: int = 10) -> None: ...
    def add_layer(self, segments: Segments, layers: int) -> Body: ...
    def add_body(
        self,
        type: str,
        pose: _Triple,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
    ) -> Body: ...
    def step(self, dt: float) -> None: ...
    @overload
    def scan(
        self,
        fan: BeamFan,
        pose: _Triple,
        range: float,
        layers: int = 0xFFFF,
        reflectance_layers: int = 0,
    ) -> tuple[Float32Array, Float32Array]: ...
    @overload
    def scan(self, lidar: Lidar) -> tuple[Float32Array, Float32Array]: ...
    def set_contact_listener(self, listener: Callable[..., None] | None) -> None:
        """`listener(moment, id_a, id_b, contact, ...)` hears of contacts; see `listen_to_contacts`.

        It is called within `step`, and within `Body.remove` for the contacts that this ends, with
        the Manifold of the step before at PRE_SOLVE, and the ContactImpulse at POST_SOLVE. What it
        raises, `step` raises.
        """
    @property
    def body_count(self) -> int: ...
    @property
    def joint_count(self) -> int: ...

class Body:
    """A handle of a body, equal to others of the same body."""

    @property
    def id(self) -> int:
        """Unique among all bodies that the world has ever had."""
    def __hash__(self) -> int: ...
    @property
    def alive(self) -> bool: ...
    def remove(self) -> None: ...
    def add_circle(
        self,
        center: _Pair,
        radius: float,
        *,
        density: float,
        friction: float = 0.0,
        restitution: float = 0.0,
        sensor: bool = False,
        collides: bool = True,
        visible: bool = True,
        layers: int = 0xFFFF,
    ) -> Fixture: ...
    def add_polygon(
        self,
        vertices: Sequence[_Pair],
        *,
        density: float,
        friction: float = 0.0,
        restitution: float = 0.0,
        sensor: bool = False,
        collides: bool = True,
        visible: bool = True,
        layers: int = 0xFFFF,
    ) -> Fixture: ...
    @property
    def fixtures(self) -> list[Fixture]:
        """In the order in which they were added."""
    def add_revolute(
        self,
        other: Body,
        anchor: _Pair,
        other_anchor: _Pair,
        *,
        collide_connected: bool = False,
        limits: _Pair | None = None,
    ) -> Joint: ...
    def add_weld(
        self,
        other: Body,
        anchor: _Pair,
        other_anchor: _Pair,
        *,
        collide_connected: bool = False,
        angle: float = 0.0,
        frequency: float = 0.0,
        damping: float = 0.0,
    ) -> Joint: ...
    def add_drive(
        self,
        linear_limits: _Triple = (0.0, 0.0, 0.0),
        angular_limits: _Triple = (0.0, 0.0, 0.0),
    ) -> Drive:
        """Limits: acceleration, deceleration, velocity; 0 is none."""
    def add_tricycle(
        self,
        front_wheel: Joint,
        rear_axle: _Pair,
        max_steer_angle: float = 0.0,
        linear_limits: _Triple = (0.0, 0.0, 0.0),
        steering_limits: _Triple = (0.0, 0.0, 0.0),
    ) -> Tricycle:
        """`front_wheel` is a revolute joint of this body, `rear_axle` the axle's middle [m]."""
    def add_lidar(
        self,
        fan: BeamFan,
        pose: _Triple,
        range: float,
        layers: int = 0xFFFF,
        reflectance_layers: int = 0,
    ) -> Lidar:
        """At a pose in this body's frame."""
    def add_tween(
        self, delta: _Triple, duration: float, mode: str = "yoyo", easing: str = "linear"
    ) -> Tween:
        """Mode and easing are of TWEEN_MODES and EASINGS."""
    @property
    def pose(self) -> _Triple:
        """Of the origin in the world [m, m, rad]; the yaw counts whole turns.

        Not to be set in the hooks of contacts.
        """
    @pose.setter
    def pose(self, pose: _Triple) -> None: ...
    @property
    def velocity(self) -> _Triple:
        """Of the origin, in the world's frame [m/s, m/s, rad/s]."""
    @velocity.setter
    def velocity(self, velocity: _Triple) -> None: ...
    @property
    def local_velocity(self) -> _Triple:
        """Of the origin, in the body's frame."""
    def velocity_at(self, point: _Pair) -> _Pair:
        """Of the body's matter at a point of the world."""
    def halt(self) -> None:
        """Stops the body and its drives."""
    def apply_force(self, force: _Pair, point: _Pair | None = None) -> None:
        """For the coming step [N], at a point of the world, by default the centre of mass.

        In the hooks of contacts, for the next step.
        """
    def apply_torque(self, torque: float) -> None:
        """For the coming step [N m]."""
    def apply_linear_impulse(self, impulse: _Pair, point: _Pair | None = None) -> None:
        """At once [N s], at a point of the world, by default the centre of mass."""
    def apply_angular_impulse(self, impulse: float) -> None:
        """At once [N m s]."""
    def world_point(self, point: _Pair) -> _Pair: ...
    def local_point(self, point: _Pair) -> _Pair: ...
    def world_vector(self, vector: _Pair) -> _Pair: ...
    def local_vector(self, vector: _Pair) -> _Pair: ...
    @property
    def type(self) -> str:
        """static, kinematic or dynamic."""
    @property
    def mass(self) -> float:
        """[kg]; 0 unless dynamic."""
    @property
    def inertia(self) -> float:
        """Moment of inertia about the centre of mass [kg m^2]; 0 unless dynamic."""
    @property
    def center(self) -> _Pair:
        """Centre of mass in the world [m]."""
    @property
    def awake(self) -> bool: ...
    def listen_to_contacts(self, hooks: int) -> None:
        """Of which moments of its contacts the world's listener hears: BEGIN_CONTACT | ..."""

class RelativePoses:
    """The poses of bodies in the frame of another one, all in one call."""

    def __init__(self, reference: Body, bodies: Sequence[Body]) -> None: ...
    def read(self) -> list[_Triple]:
        """By body [m, m, rad]: the difference of two yaws that lie within [-pi, pi]."""

class Fixture:
    """A shape of a body, or a wall of a layer."""

    @property
    def body(self) -> Body: ...
    @property
    def index(self) -> int:
        """Among the fixtures of its body; of a wall, among those put up together with it."""
    def __hash__(self) -> int: ...
    @property
    def density(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, friction: float) -> None: ...
    @property
    def restitution(self) -> float: ...
    @restitution.setter
    def restitution(self, restitution: float) -> None: ...
    @property
    def sensor(self) -> bool: ...
    @property
    def collides(self) -> bool: ...
    @property
    def visible(self) -> bool: ...
    @property
    def layers(self) -> int:
        """Bits of its collision layers."""
    def test_point(self, point: _Pair) -> bool:
        """Whether a point of the world is within; never within a wall."""

BEGIN_CONTACT: int
END_CONTACT: int
PRE_SOLVE: int
POST_SOLVE: int

class Contact:
    """Two fixtures that touch. Of use only in the hook that it was given to; then GoneError.

    Equal, as a key too, to itself in its other hooks, from its begin to its end.
    """

    def __hash__(self) -> int: ...
    @property
    def fixture_a(self) -> Fixture: ...
    @property
    def fixture_b(self) -> Fixture: ...
    @property
    def touching(self) -> bool: ...
    @property
    def enabled(self) -> bool: ...
    def set_enabled(self, enabled: bool) -> None:
        """In pre_solve: whether the two push each other apart in this step."""
    @property
    def points(self) -> list[_Pair]:
        """Up to two places in the world [m]; none with a sensor."""
    @property
    def normal(self) -> _Pair:
        """Unit vector from a to b, in the world; zero with a sensor."""
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, friction: float) -> None: ...
    @property
    def restitution(self) -> float: ...
    @restitution.setter
    def restitution(self, restitution: float) -> None: ...
    @property
    def tangent_speed(self) -> float:
        """The surface's own speed, as of a conveyor belt [m/s]."""
    @tangent_speed.setter
    def tangent_speed(self, tangent_speed: float) -> None: ...

class ContactImpulse:
    """What the solver did at the points of a contact [N s]."""

    @property
    def normal_impulses(self) -> list[float]: ...
    @property
    def tangent_impulses(self) -> list[float]: ...

class Manifold(ContactImpulse):
    """The points of a contact in the step before, with its impulses."""

    @property
    def local_points(self) -> list[_Pair]:
        """In the frame of the body that Box2D reckons them in; see b2Manifold."""

class Joint:
    @property
    def alive(self) -> bool: ...
    @property
    def angle(self) -> float: ...

class Drive:
    def command(self, vx: float, vy: float, omega: float) -> None: ...
    @property
    def target(self) -> _Triple: ...
    @property
    def velocity(self) -> _Triple: ...

class Tricycle:
    def command(self, speed: float, steer_angle: float) -> None:
        """Of the front wheel [m/s, rad]."""
    @property
    def speed(self) -> float: ...
    @property
    def steer_angle(self) -> float: ...

TWEEN_MODES: tuple[str, ...]
EASINGS: tuple[str, ...]

class Tween:
    def trigger(self, forward: bool) -> None:
        """In mode trigger: towards the end, or back towards the start."""
    @property
    def progress(self) -> float:
        """How much of the way's time is behind it, 0 to 1; not eased."""

class PriorityGuard:
    """Takes real-time priority from the thread that creates it, if that computes for too long.

    It then also runs the handler that the signal had before. Linux only; one per process.
    """

    def __init__(self, signal: int) -> None:
        """Handles `signal`, which it has sent to the calling thread.

        Raises:
            RuntimeError: the system refuses it.
        """

    def arm(self, seconds: float) -> None:
        """Allows the thread so much CPU time from now on [s]."""

    def disarm(self) -> None:
        """Allows it any CPU time."""

    @property
    def has_fired(self) -> bool:
        """Whether the thread has used up its time."""
