"""The machine and the version of the code that was measured."""

import os
import platform
import subprocess
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple, Optional
from xml.etree import ElementTree


class Machine(NamedTuple):
    """The machine that the benchmark ran on."""

    system: str
    processor: str
    cores: int
    load: float  # average of the minute before the benchmark began

    @classmethod
    def this(cls) -> "Machine":
        """This machine."""
        return cls(
            platform.platform(),
            _processor(Path("/proc/cpuinfo")),
            len(os.sched_getaffinity(0)),
            round(os.getloadavg()[0], 2),
        )


def _processor(cpuinfo: Path) -> str:
    """The processor's model name where the system has it (x86), else the architecture."""
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip()
    return platform.machine()


def version() -> str:
    """The version of flatland_server."""
    import rospkg

    return str(rospkg.RosPack().get_manifest("flatland_server").version)


def version_of(package: Path) -> str:
    """The version in a package.xml."""
    return ElementTree.parse(package).findtext("version") or "unknown"


def commit() -> Optional[str]:
    """The commit of the clone that this runs from, with "-dirty" if files were changed, or None."""
    return commit_of(Path(__file__).resolve())


def commit_of(file: Path) -> Optional[str]:
    """The commit of the clone that contains a file; see `commit`."""
    try:
        # Fails in a repository that contains this file's folder without tracking it.
        _git(file.parent, "ls-files", "--error-unmatch", file.name)
        return _git(file.parent, "describe", "--always", "--dirty", "--abbrev=12")
    except (OSError, subprocess.CalledProcessError):
        return None


def _git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    return subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True, text=True
    ).stdout.strip()


def now() -> str:
    """The current time in UTC, in ISO 8601."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")
