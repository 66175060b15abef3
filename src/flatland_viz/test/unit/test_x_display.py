"""The choice of an X display, on desktops of X and of Wayland."""

import os

import pytest

from flatland_viz.x_display import choose_x


@pytest.mark.parametrize("platform", [None, "", "wayland", "wayland-egl", "wayland;xcb", "xcb"])
def test_qt_draws_by_x_where_there_is_a_display(platform, display, monkeypatch):
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    monkeypatch.setenv("QT_QPA_PLATFORM", platform or "")
    if platform is None:
        monkeypatch.delenv("QT_QPA_PLATFORM")
    assert choose_x() == ""
    assert os.environ["QT_QPA_PLATFORM"] == "xcb"


def test_the_missing_display_is_named(display, monkeypatch):
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    assert choose_x() == "QT_QPA_PLATFORM is 'offscreen', and rviz needs 'xcb'"
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert choose_x() == "no display"
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert choose_x() == "no X display, which rviz needs (XWayland)"
    assert os.environ["QT_QPA_PLATFORM"] == "offscreen"
