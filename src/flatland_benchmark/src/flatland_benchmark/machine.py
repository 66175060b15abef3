"""What figures depend on besides the code that is measured: the machine, and which code it was."""

import os
import platform
import subprocess
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple, Optional


class Machine(NamedTuple):
    """Where it ran."""

    system: str
    processor: str
    cores: int
    load: float  # of the last minute, when the benchmark began

    @classmethod
    def this(cls) -> "Machine":
        """The machine that this runs on."""
        return cls(
            platform.platform(),
            _processor(Path("/proc/cpuinfo")),
            len(os.sched_getaffinity(0)),
            round(os.getloadavg()[0], 2),
        )


def _processor(cpuinfo: Path) -> str:
    """The name of the model where the system tells it (x86), else the architecture."""
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip()
    return platform.machine()


def version() -> str:
    """Of this package."""
    import rospkg

    return str(rospkg.RosPack().get_manifest("flatland_server").version)


def commit() -> Optional[str]:
    """Of the clone that this is run from, with "-dirty" if it was changed; or None."""
    here = Path(__file__).resolve()
    try:
        # A folder that merely lies in some other repository is none of it.
        _git(here.parent, "ls-files", "--error-unmatch", here.name)
        return _git(here.parent, "describe", "--always", "--dirty", "--abbrev=12")
    except (OSError, subprocess.CalledProcessError):
        return None


def _git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    return subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True, text=True
    ).stdout.strip()


def now() -> str:
    """The moment, as ISO 8601 writes it."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")
