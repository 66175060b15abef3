"""The message where SDL lacks a library to open an X display."""

import ctypes

import pytest

from flatland2d.viewer.display_libraries import missing_libraries


@pytest.mark.parametrize(
    ("absent", "problem"),
    [
        (set(), ""),
        ({"libXext.so.6"}, "libXext.so.6 is missing: apt install libxext6"),
        (
            {"libX11.so.6", "libXext.so.6"},
            "libX11.so.6 and libXext.so.6 are missing: apt install libx11-6 libxext6",
        ),
    ],
)
def test_libraries_that_are_missing_are_named_with_their_packages(monkeypatch, absent, problem):
    def load(name):
        if name in absent:
            raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", load)
    assert missing_libraries() == problem
