"""The progress of a sweep: a bar on a terminal, lines elsewhere, on standard error."""

import sys
import time
from contextlib import contextmanager
from typing import Any, Iterator

from flatland2d.sweep.runner import Result

_LINE_PERIOD = 5.0
"""Real time between two lines, where there is no terminal [s]."""


class Progress:
    """Counts scenarios; shows nothing.

    Args:
        total: number of scenarios.
        done: number of scenarios that are done already.
    """

    def __init__(self, total: int, done: int) -> None:
        self.total = total
        self.done = done
        self._succeeded = self._failed = 0

    def count(self, result: Result) -> None:
        """Notes a scenario that is done."""
        self.done += 1
        self._succeeded += result.row.get("success") is True
        self._failed += bool(result.error)
        self.show()

    def say(self, message: str) -> None:
        """Shows a sentence."""
        print(message, file=sys.stderr, flush=True)

    def show(self) -> None:
        """Shows the progress."""

    def end(self) -> None:
        """Shows the last state."""

    @property
    def _state(self) -> str:
        failed = f", {self._failed} failed" if self._failed else ""
        return f"{self._succeeded} with success{failed}"


class _Lines(Progress):
    """A line at the beginning, from time to time, and at the end."""

    def __init__(self, total: int, done: int) -> None:
        super().__init__(total, done)
        self._begin = self._last = time.monotonic()
        self._first = done + 1
        self._first_time = self._begin
        self._shown = -1

    def show(self) -> None:
        now = time.monotonic()
        if self.done == self._first:
            self._first_time = now
        if now - self._last >= _LINE_PERIOD or self.done == self._first:
            self._last = now
            self._print()

    def end(self) -> None:
        if self.done > self._shown:
            self._print()

    def _print(self) -> None:
        self._shown = self.done
        now = time.monotonic()
        rest, since_first = self.total - self.done, self.done - self._first
        left = ""
        if rest and since_first > 0:  # workers take a while to start: the first one says little
            left = f", {(now - self._first_time) * rest / since_first:.0f} s left"
        elapsed = now - self._begin
        self.say(f"{self.done} of {self.total} scenarios, {self._state}, {elapsed:.0f} s{left}")


class _Bar(Progress):
    """A bar of tqdm."""

    def __init__(self, total: int, done: int, bar: Any) -> None:
        super().__init__(total, done)
        self._bar = bar

    def say(self, message: str) -> None:
        self._bar.write(message, file=sys.stderr)

    def show(self) -> None:
        self._bar.set_postfix_str(self._state, refresh=False)
        self._bar.update(self.done - self._bar.n)


@contextmanager
def show_progress(total: int, done: int, is_wanted: bool) -> Iterator[Progress]:
    """Shows the progress of a sweep: a bar if standard error is a terminal and tqdm is installed.

    Args:
        total: number of scenarios.
        done: number of scenarios that are done already.
        is_wanted: whether anything is shown.
    """
    if not is_wanted:
        yield Progress(total, done)
        return
    if sys.stderr.isatty():
        try:
            import tqdm
        except ImportError:
            pass
        else:
            with tqdm.tqdm(total=total, initial=done, unit=" scenarios") as bar:
                yield _Bar(total, done, bar)
            return
    yield _Lines(total, done)
