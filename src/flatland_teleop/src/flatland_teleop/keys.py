"""Keys from the bytes that a terminal sends.

Most terminals send a key when it is pressed, and again while it is held; they do not
report releases. Terminals with the keyboard protocol of kitty do so on request:
https://sw.kovidgoyal.net/kitty/keyboard-protocol
"""

import re
from typing import Iterator, NamedTuple, Optional

ENABLE_REPORTS = "\x1b[>11u\x1b[?1004h"
"""Requests releases by flags 1 (unambiguous escape codes), 2 (event types) and 8 (all keys as
escape codes), and events of lost focus, after which no release arrives. Other terminals ignore
these sequences."""
DISABLE_REPORTS = "\x1b[?1004l\x1b[<u"

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_CONTROL, _SHIFT = 4, 1  # bits of the protocol's modifiers; the terminal sends their sum plus one
_FOCUS_OUT = "\x1b[O"
_RELEASE = 3  # the protocol's event type

_ESCAPE = re.compile(r"\x1b(?:\[(?P<numbers>[0-9;:]*)(?P<end>[ -/]*[@-~])|O(?P<keypad>[A-Z]))")
_UNFINISHED = re.compile(r"\x1b(?:\[[0-9;:]*|O)?")


class KeyEvent(NamedTuple):
    """A key: a character, or "up", "down", "left", "right", "tab", "quit", "focus_out".

    Letters are small ones.

    Attributes:
        key: which one.
        is_release: whether it was released; otherwise it was pressed, or is still held.
        has_releases: whether the terminal sends its release, too.
        has_shift: whether Shift is held; only for letters and arrows.
    """

    key: str
    is_release: bool = False
    has_releases: bool = False
    has_shift: bool = False


class KeyDecoder:
    """Splits what a terminal sends into keys. A sequence may arrive in pieces."""

    def __init__(self) -> None:
        self._rest = ""

    def decode(self, text: str) -> Iterator[KeyEvent]:
        """The keys in what has arrived."""
        text = self._rest + text
        self._rest = ""
        position = 0
        while position < len(text):
            if _UNFINISHED.fullmatch(text, position):
                self._rest = text[position:]
                return
            match = _ESCAPE.match(text, position)
            event = _escape_event(match) if match else _plain_event(text[position])
            position = match.end() if match else position + 1
            if event:
                yield event


def _plain_event(character: str) -> Optional[KeyEvent]:
    if character in "\x03\x04":  # Ctrl-C and Ctrl-D, where the terminal does not make signals
        return KeyEvent("quit")
    if character == "\t":
        return KeyEvent("tab")
    if not character.isprintable():
        return None
    return KeyEvent(character.lower(), has_shift=character.isupper())


def _escape_event(match: "re.Match[str]") -> Optional[KeyEvent]:
    if match["keypad"]:  # an arrow of a terminal in application mode
        name = _ARROWS.get(match["keypad"])
        return KeyEvent(name) if name else None
    if match[0] == _FOCUS_OUT:
        return KeyEvent("focus_out")
    fields = [field.split(":") for field in match["numbers"].split(";")]
    modifiers, kind = 0, 0
    if len(fields) > 1:
        modifiers = int(fields[1][0] or 1) - 1
        kind = int(fields[1][1] or 0) if len(fields[1]) > 1 else 0
    is_protocol = match["end"] == "u" or kind > 0
    if match["end"] == "u":
        name = _protocol_key(int(fields[0][0] or 0), modifiers)
    else:
        name = _ARROWS.get(match["end"])
    if name is None:
        return None
    is_directed = name in _ARROWS.values() or (name.isalpha() and len(name) == 1)
    has_shift = is_directed and bool(modifiers & _SHIFT)
    return KeyEvent(name, kind == _RELEASE, is_protocol, has_shift)


def _protocol_key(code: int, modifiers: int) -> Optional[str]:
    if modifiers & _CONTROL:
        return "quit" if chr(code) in "cd" else None
    if code == ord("\t"):
        return "tab"
    if not 32 <= code < 0xE000 or not chr(code).isprintable():
        return None  # escape, enter, modifiers and the like
    return chr(code)
