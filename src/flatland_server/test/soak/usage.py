"""Resources of a process: memory, open files, threads."""

import os
from pathlib import Path
from typing import List, NamedTuple

from waiting import wait_until

REST = 200
"""Equal readings in a row of files and threads, 5 ms apart, for a process to be at rest."""


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
    def at_rest(cls, pid: int) -> "Usage":
        """The resources of a process when the threads of closed connections have ended."""
        usages: List[Usage] = []

        def is_at_rest() -> bool:
            usages.append(cls.of(pid))
            latest = usages[-REST:]
            return len(latest) == REST and len({usage[1:] for usage in latest}) == 1

        wait_until(is_at_rest, f"the process {pid} to be at rest", interval=0.005)
        return usages[-1]

    def has_no_more_than(self, other: "Usage") -> bool:
        """True if there are at most as many open files and threads."""
        return self.open_files <= other.open_files and self.threads <= other.threads
