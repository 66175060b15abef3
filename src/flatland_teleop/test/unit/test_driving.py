"""Commands from keys."""

import pytest

from flatland_teleop.driving import Command, Driving
from flatland_teleop.keys import KeyEvent


@pytest.fixture
def driving():
    return Driving(speed=1.0, turn=2.0, first_timeout=0.7, repeat_timeout=0.2)


@pytest.mark.parametrize(
    ("key", "command"),
    [
        ("w", Command(x=1)),
        ("up", Command(x=1)),
        ("down", Command(x=-1)),
        ("a", Command(yaw=2)),
        ("right", Command(yaw=-2)),
        ("q", Command(y=1)),
        ("e", Command(y=-1)),
        ("z", Command()),
    ],
)
def test_keys_drive(driving, key, command):
    driving.on_key(KeyEvent(key), now=10.0)
    assert driving.command(10.0) == command


def test_shift_drives_half_as_fast_until_it_is_released(driving):
    driving.on_key(KeyEvent("w", has_releases=True, has_shift=True), now=0.0)
    driving.on_key(KeyEvent("a", has_releases=True, has_shift=True), now=0.0)
    assert driving.command(0.0) == Command(x=0.5, yaw=1)
    driving.on_key(KeyEvent("w", is_release=True, has_releases=True), now=0.1)
    assert driving.command(0.1) == Command(yaw=2)


def test_a_key_typed_once_is_held_until_it_would_repeat(driving):
    driving.on_key(KeyEvent("w"), now=0.0)
    assert driving.command(0.69) == Command(x=1)
    assert driving.command(0.71) == Command()


def test_a_repeating_key_is_released_soon_after_its_last_repeat(driving):
    driving.on_key(KeyEvent("w"), now=0.0)
    driving.on_key(KeyEvent("w"), now=0.5)
    assert driving.command(0.69) == Command(x=1)
    assert driving.command(0.71) == Command()


def test_another_key_takes_the_place_of_the_one_before(driving):
    driving.on_key(KeyEvent("w"), now=0.0)
    driving.on_key(KeyEvent("a"), now=0.1)
    assert driving.command(0.2) == Command(yaw=2)


def test_terminals_with_release_events_allow_several_held_keys(driving):
    driving.on_key(KeyEvent("w", has_releases=True), now=0.0)
    driving.on_key(KeyEvent("a", has_releases=True), now=0.0)
    assert driving.command(100.0) == Command(x=1, yaw=2)
    driving.on_key(KeyEvent("w", is_release=True, has_releases=True), now=100.0)
    assert driving.command(100.0) == Command(yaw=2)
    driving.on_key(KeyEvent("s", has_releases=True), now=100.0)
    driving.on_key(KeyEvent("w", has_releases=True), now=100.0)
    assert driving.command(100.0) == Command(yaw=2)


@pytest.mark.parametrize("key", [" ", "focus_out"])
def test_a_robot_stops_at_once(driving, key):
    driving.on_key(KeyEvent("w", has_releases=True), now=0.0)
    driving.on_key(KeyEvent(key), now=0.1)
    assert driving.command(0.1) == Command()


def test_speeds_change(driving):
    for key in "++.":
        driving.on_key(KeyEvent(key), now=0.0)
    assert (driving.speed, driving.turn) == pytest.approx((1.1**2, 2 * 1.1**3))
    for key in "--,":
        driving.on_key(KeyEvent(key), now=0.0)
    assert (driving.speed, driving.turn) == pytest.approx((1.0, 2.0))
