"""Resources of a process: memory, open files, threads."""

import os
from pathlib import Path
from typing import NamedTuple


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

    def has_no_more_than(self, other: "Usage") -> bool:
        """True if there are at most as many open files and threads."""
        return self.open_files <= other.open_files and self.threads <= other.threads
