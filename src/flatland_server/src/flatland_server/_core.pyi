"""Flatland's physics and ray casting on Box2D; see include/flatland_server/world.hpp.

Using a handle whose object was deleted raises GoneError; a value that Box2D could not digest raises
ValueError; using the world while another thread does raises RuntimeError.
"""

from typing import Sequence

from flatland_server.arrays import Float32Array, Segments

_Pair = tuple[float, float]
_Triple = tuple[float, float, float]

class GoneError(ReferenceError): ...

class BeamFan:
    def __init__(self, angle_min: float, increment: float, count: int) -> None: ...
    def __len__(self) -> int: ...

class World:
    def __init__(self, velocity_iterations: int = 10, position_iterations: int = 10) -> None: ...
    def add_layer(self, segments: Segments, layers: int) -> None: ...
    def add_body(
        self,
        type: str,
        pose: _Triple,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
    ) -> Body: ...
    def step(self, dt: float) -> None: ...
    def scan(
        self,
        fan: BeamFan,
        pose: _Triple,
        range: float,
        layers: int = 0xFFFF,
        reflectance_layers: int = 0,
    ) -> tuple[Float32Array, Float32Array]: ...
    @property
    def body_count(self) -> int: ...
    @property
    def joint_count(self) -> int: ...

class Body:
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
        layers: int = 0xFFFF,
    ) -> None: ...
    def add_polygon(
        self,
        vertices: Sequence[_Pair],
        *,
        density: float,
        friction: float = 0.0,
        restitution: float = 0.0,
        sensor: bool = False,
        collides: bool = True,
        layers: int = 0xFFFF,
    ) -> None: ...
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
    ) -> Drive: ...
    def remove(self) -> None: ...
    @property
    def alive(self) -> bool: ...
    @property
    def pose(self) -> _Triple: ...
    @pose.setter
    def pose(self, pose: _Triple) -> None: ...
    @property
    def velocity(self) -> _Triple: ...
    @velocity.setter
    def velocity(self, velocity: _Triple) -> None: ...
    @property
    def local_velocity(self) -> _Triple: ...
    @property
    def mass(self) -> float: ...
    def apply_force(self, force: _Pair, torque: float = 0.0) -> None: ...
    def halt(self) -> None: ...

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
