"""Methods of the core that every step calls, which have no conversions by pybind11."""

import numpy as np
import pytest

from flatland_server import _core

LIMITS = (0.0, 0.0, 0.0)


@pytest.fixture
def drive():
    return _core.World().add_body("dynamic", (0, 0, 0)).add_drive(LIMITS, LIMITS)


def test_fast_methods_take_numbers_of_all_types(drive):
    drive.command(1, np.float32(0.5), np.int64(2))

    assert drive.target == (1.0, 0.5, 2.0)
    drive.command(3.0, omega=1.0, vy=2.0)
    assert drive.target == (3.0, 2.0, 1.0)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((1.0, 2.0), TypeError, "expected 3 arguments, found 2"),
        ((1.0, 2.0, "x"), TypeError, "must be real number, not str"),
        ((1.0, 2.0, 10**400), OverflowError, "int too large"),
        ((1.0, 2.0, float("nan")), ValueError, "finite"),
    ],
)
def test_wrong_arguments_are_refused(drive, arguments, error, message):
    with pytest.raises(error, match=message):
        drive.command(*arguments)
    for keywords in ({"vx": 1.0}, {"speed": 1.0}):
        with pytest.raises(TypeError, match="unexpected argument"):
            drive.command(1.0, 2.0, **keywords)
    assert drive.target == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("count", "error"), [(0, ValueError), (2**40, OverflowError), (1.5, TypeError)]
)
def test_a_count_is_an_int_of_1_or_more(count, error):
    with pytest.raises(error):
        _core.World().step_until_contact(0.1, count)


def test_an_object_without_init_is_refused(drive):
    with pytest.raises(TypeError, match="__init__ was not called"):
        _core.World.__new__(_core.World).step(0.1)
    with pytest.raises(TypeError, match="doesn't apply to a 'int' object"):
        type(drive).command(3, 1.0, 2.0, 3.0)
