"""Times and durations in messages, against ROS's."""

import genpy
import pytest

from flatland_server.messages import times


@pytest.mark.parametrize("kind", ["Time", "Duration"])
def test_times_are_those_of_ros(kind):
    ours, ros = getattr(times, kind), getattr(genpy, kind)

    for args in ((), (3,), (3, 4), (2, 3_500_000_000), (1.25,), (0, 999_999_999)):
        a, b = ours(*args), ros(*args)
        for method in ("to_sec", "to_nsec", "is_zero", "__str__", "__hash__", "__bool__"):
            assert getattr(a, method)() == getattr(b, method)()
        assert (a.secs, a.nsecs) == (b.secs, b.nsecs)
    assert ours.from_sec(2.75) == ours(2, 750_000_000) != ours(2)
    assert ours(1) < ours(1, 1) <= ours(1, 1) < ours(2) >= ours(1) > ours(0, 5)
    with pytest.raises(TypeError):
        ours(1) < 1.0  # noqa: B015
    with pytest.raises(ValueError, match="whole seconds"):
        ours(1.5, 1)


def test_time_arithmetic_equals_that_of_ros():
    for kit in (times, genpy):
        time, duration = kit.Time, kit.Duration
        assert time(5, 1) - time(3, 2) == duration(1, 999_999_999)
        assert time(5) - duration(0, 1) == time(4, 999_999_999)
        assert time(5) + duration(1, 5) == duration(1, 5) + time(5) == time(6, 5)
        assert duration(1) + duration(2) - duration(0, 1) == duration(2, 999_999_999)
        assert abs(-duration(2)) == duration(1) * 2 == duration(4) / 2 == duration(8) * 0.25
        assert duration(6) / duration(4) == 1.5
        assert duration(7) // duration(4) == 1
        with pytest.raises(TypeError):
            time(1) - duration(2)
