"""Times and durations in messages, where ROS's own are missing: `genpy.Time`, `genpy.Duration`.

These have the interface of ROS's, so that a program runs with either.
"""

from typing import Any, Type, TypeVar, Union

_NANO = 1_000_000_000

T = TypeVar("T", bound="_Seconds")


class _Seconds:
    """Whole seconds and nanoseconds; `nsecs` is in [0, 1e9)."""

    __slots__ = ("nsecs", "secs")

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        if isinstance(secs, float) and nsecs:
            raise ValueError("expected whole seconds with nanoseconds, found a fraction of seconds")
        self.secs, self.nsecs = divmod(_nanoseconds(secs) + int(nsecs), _NANO)

    @classmethod
    def from_sec(cls: Type[T], seconds: float) -> T:
        """A time or duration of so many seconds, cut to whole nanoseconds."""
        return cls(float(seconds))

    def set(self, secs: int, nsecs: int) -> None:
        """Sets both fields, as they are."""
        self.secs, self.nsecs = secs, nsecs

    def canon(self) -> None:
        """Brings `nsecs` into [0, 1e9) after the fields were set directly."""
        self.secs, self.nsecs = divmod(self.to_nsec(), _NANO)

    def to_sec(self) -> float:
        """Converts to seconds."""
        return self.secs + self.nsecs / 1e9

    def to_nsec(self) -> int:
        """Converts to nanoseconds."""
        return self.secs * _NANO + self.nsecs

    def is_zero(self) -> bool:
        """True if both fields are zero."""
        return self.secs == 0 and self.nsecs == 0

    def __bool__(self) -> bool:
        return not self.is_zero()

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.to_nsec() == _as(other)

    def __lt__(self: T, other: T) -> bool:
        return self.to_nsec() < _as(other) if type(self) is type(other) else NotImplemented

    def __le__(self: T, other: T) -> bool:
        return self.to_nsec() <= _as(other) if type(self) is type(other) else NotImplemented

    def __gt__(self: T, other: T) -> bool:
        return self.to_nsec() > _as(other) if type(self) is type(other) else NotImplemented

    def __ge__(self: T, other: T) -> bool:
        return self.to_nsec() >= _as(other) if type(self) is type(other) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.secs, self.nsecs))

    def __str__(self) -> str:
        return str(self.to_nsec())

    def __repr__(self) -> str:
        return f"{type(self).__name__}(secs={self.secs}, nsecs={self.nsecs})"


class Time(_Seconds):
    """A time: seconds and nanoseconds since time 0, which in a simulation is its start."""

    __slots__ = ()

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        super().__init__(secs, nsecs)
        if self.secs < 0:
            raise TypeError(f"expected a time of 0 or later, found {self.to_sec():g} s")

    def to_time(self) -> float:
        """Converts to seconds."""
        return self.to_sec()

    def __add__(self, other: "Duration") -> "Time":
        return Time(0, self.to_nsec() + _as(other)) if _is_duration(other) else NotImplemented

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if isinstance(other, Time):
            return Duration(0, self.to_nsec() - other.to_nsec())
        return Time(0, self.to_nsec() - _as(other)) if _is_duration(other) else NotImplemented


class Duration(_Seconds):
    """A difference of two times."""

    __slots__ = ()

    def __neg__(self) -> "Duration":
        return Duration(0, -self.to_nsec())

    def __abs__(self) -> "Duration":
        return Duration(0, abs(self.to_nsec()))

    def __add__(self, other: "Duration") -> "Duration":
        return Duration(0, self.to_nsec() + _as(other)) if _is_duration(other) else NotImplemented

    def __sub__(self, other: "Duration") -> "Duration":
        return Duration(0, self.to_nsec() - _as(other)) if _is_duration(other) else NotImplemented

    def __mul__(self, factor: float) -> "Duration":
        if isinstance(factor, int):
            return Duration(0, self.to_nsec() * factor)
        return Duration.from_sec(self.to_sec() * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Union[float, "Duration"]) -> Any:
        if isinstance(divisor, Duration):
            return self.to_sec() / divisor.to_sec()
        return Duration.from_sec(self.to_sec() / divisor)

    def __floordiv__(self, divisor: Union[float, "Duration"]) -> Any:
        if isinstance(divisor, Duration):
            return int(self.to_sec() // divisor.to_sec())
        return Duration.from_sec(self.to_sec() // divisor)


def _nanoseconds(seconds: float) -> int:
    """Cuts a fraction to whole nanoseconds, towards 0."""
    whole = int(seconds)
    return whole * _NANO + int((seconds - whole) * _NANO)


def _as(time: Any) -> int:
    nanoseconds: int = time.to_nsec()
    return nanoseconds


def _is_duration(value: object) -> bool:
    return isinstance(value, Duration)
