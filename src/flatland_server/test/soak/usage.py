"""Resources of a process: memory, open files, threads."""

import os
import time
from pathlib import Path
from typing import NamedTuple

MOST_GROWTH = 1.05
"""Largest ratio of the memory at the end to that after the warm-up."""


class Usage(NamedTuple):
    """The resources of a process at one time."""

    memory: float
    """Resident memory [MB]."""

    open_files: int
    threads: int

    @classmethod
    def of(cls, pid: int) -> "Usage":
        """The present resources of a process."""
        status = Path(f"/proc/{pid}/status").read_text()
        values = dict(line.split(":", 1) for line in status.splitlines())
        files = len(os.listdir(f"/proc/{pid}/fd"))
        return cls(int(values["VmRSS"].split()[0]) / 1024, files, int(values["Threads"]))

    @classmethod
    def largest(cls, pid: int, seconds: float) -> "Usage":
        """The most of each that a process has within a time [s]."""
        end = time.monotonic() + seconds
        usages = [cls.of(pid)]
        while time.monotonic() < end:
            usages.append(cls.of(pid))
            time.sleep(0.005)
        return cls(*map(max, zip(*usages)))

    def has_no_more_than(self, other: "Usage") -> bool:
        """True if there are at most as many open files and threads."""
        return self.open_files <= other.open_files and self.threads <= other.threads
