"""The choice of screens for tests of the window."""

from argparse import ArgumentTypeError
from pathlib import Path

import pytest
from screens import SCREENS, USUAL, chosen, screens_option

MODULES = {path.stem for path in Path(__file__).resolve().parents[1].glob("test_gui_*.py")}


def test_each_screen_is_used_and_each_module_has_one():
    assert set(USUAL) == MODULES
    used = [screen for viewers in USUAL.values() for screen in viewers.values()]
    assert sorted(used) == sorted(SCREENS)


def test_screens_are_chosen_by_their_names():
    assert chosen("test_gui_fits", "usual") == [("window", "2x-light")]
    both = [("window", "2x-dark"), ("rviz", "2x-dark")]
    assert chosen("test_gui_viewers", "2x-dark") == both
    assert [screen for _, screen in chosen("test_gui_life", "all")] == list(SCREENS)
    assert screens_option("2x-dark,1024x700-light") == "2x-dark,1024x700-light"
    with pytest.raises(ArgumentTypeError, match=r"1280x800-light, .*; found 3x-light"):
        screens_option("2x-dark,3x-light")
