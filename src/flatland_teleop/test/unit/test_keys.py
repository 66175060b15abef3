"""Keys from what terminals send."""

import pytest

from flatland_teleop.keys import KeyDecoder, KeyEvent


def keys(*pieces):
    decoder = KeyDecoder()
    return [event for piece in pieces for event in decoder.decode(piece)]


@pytest.mark.parametrize(
    ("sent", "expected"),
    [
        ("w", KeyEvent("w")),
        ("\x1b[A", KeyEvent("up")),
        ("\x1bOD", KeyEvent("left")),  # in application mode
        ("\t", KeyEvent("tab")),
        ("\x04", KeyEvent("quit")),
        ("\x1b[O", KeyEvent("focus_out")),
        ("\x1b[119;1:1u", KeyEvent("w", has_releases=True)),
        ("\x1b[119u", KeyEvent("w", has_releases=True)),
        ("\x1b[119;1:3u", KeyEvent("w", is_release=True, has_releases=True)),
        ("\x1b[97;2u", KeyEvent("a", has_releases=True, has_shift=True)),
        ("A", KeyEvent("a", has_shift=True)),
        ("\x1b[1;2A", KeyEvent("up", has_shift=True)),
        ("\x1b[1;2:1A", KeyEvent("up", has_releases=True, has_shift=True)),
        ("\x1b[1;1:3A", KeyEvent("up", is_release=True, has_releases=True)),
        ("\x1b[99;5u", KeyEvent("quit", has_releases=True)),  # Ctrl-C
        ("\x1b[9u", KeyEvent("tab", has_releases=True)),
    ],
)
def test_a_key_is_known_by_what_the_terminal_sends(sent, expected):
    assert keys(sent) == [expected]


def test_keys_arrive_together_and_in_pieces():
    assert keys("ww\x1b[", "Aa", "\x1b", "[B") == [
        KeyEvent(name) for name in ("w", "w", "up", "a", "down")
    ]


@pytest.mark.parametrize("sent", ["\x1b[I", "\x1b[5~", "\x1b[57441;2u", "\r", "\x1b[27u", "\x01"])
def test_other_keys_do_nothing(sent):
    assert keys(sent, "w") == [KeyEvent("w")]
