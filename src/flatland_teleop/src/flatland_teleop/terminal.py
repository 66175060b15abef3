"""A terminal as a keyboard and a few lines of text."""

import codecs
import os
import select
import sys
import termios
import tty
from types import TracebackType
from typing import List, Optional, Type

from flatland_teleop.keys import DISABLE_REPORTS, ENABLE_REPORTS

_HIDE_CURSOR, _SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"
_CLEAR_LINE, _CLEAR_BELOW = "\x1b[K", "\x1b[J"


class Terminal:
    """The terminal of this process, in a mode that sends keys at once. Use it with `with`.

    Raises:
        OSError: standard input or output is no terminal.
    """

    def __init__(self) -> None:
        self._input, self._output = sys.stdin.fileno(), sys.stdout.fileno()
        if not (os.isatty(self._input) and os.isatty(self._output)):
            raise OSError("this is no terminal")
        self._mode = termios.tcgetattr(self._input)
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._lines = 0

    def __enter__(self) -> "Terminal":
        tty.setcbreak(self._input)
        mode = termios.tcgetattr(self._input)
        mode[6][termios.VSUSP] = b"\0"  # Ctrl-Z would leave the terminal in this mode
        termios.tcsetattr(self._input, termios.TCSANOW, mode)
        self._write(ENABLE_REPORTS + _HIDE_CURSOR)
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self._write(DISABLE_REPORTS + _SHOW_CURSOR)
        termios.tcsetattr(self._input, termios.TCSADRAIN, self._mode)

    def _write(self, text: str) -> None:
        os.write(self._output, text.encode())

    def read(self, timeout: float) -> Optional[str]:
        """The typed text, waiting `timeout` [s] at most; None when the terminal is closed."""
        if not select.select([self._input], [], [], timeout)[0]:
            return ""
        try:
            data = os.read(self._input, 4096)
        except OSError:  # the other end of a pseudo-terminal is closed
            return None
        return self._decoder.decode(data) if data else None

    def show(self, lines: List[str]) -> None:
        """Shows lines in place of those before. What does not fit in the width is cut off."""
        width = os.get_terminal_size(self._output).columns or 80
        up = f"\x1b[{self._lines}A" if self._lines else ""
        rows = "".join(f"{line[: width - 1]}{_CLEAR_LINE}\r\n" for line in lines)
        self._write(f"{up}\r{rows}{_CLEAR_BELOW}")
        self._lines = len(lines)
