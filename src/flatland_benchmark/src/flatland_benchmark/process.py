"""A child process: its output, processor time and memory, and its end."""

import ctypes
import json
import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, TypeVar

from flatland_server.exceptions import FlatlandError

T = TypeVar("T")

_TICKS = os.sysconf("SC_CLK_TCK")
_PR_SET_PDEATHSIG = 1
_libc = ctypes.CDLL(None)


class Process:
    """A program with its output in files. It is killed when this process dies.

    Args:
        name: of the output files, and of the program in error messages.
        command: the command line.
        folder: the folder of the output files.
        environment: the program's environment.
    """

    def __init__(
        self, name: str, command: List[str], folder: Path, environment: Dict[str, str]
    ) -> None:
        self.name = name
        self._output = folder / f"{name}.out"
        self._errors = folder / f"{name}.err"
        self._read = 0
        with self._output.open("w") as output, self._errors.open("w") as errors:
            self._popen = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=errors,
                env=environment,
                start_new_session=True,  # Ctrl-C reaches this process only, which ends the program
                preexec_fn=_die_with_parent,
            )

    @property
    def output(self) -> str:
        """Its standard output so far."""
        return self._output.read_text()

    @property
    def has_ended(self) -> bool:
        """True if it has ended."""
        return self._popen.poll() is not None

    @property
    def cpu_seconds(self) -> float:
        """Processor time used so far, on all cores."""
        return cpu_seconds(self._popen.pid)

    @property
    def memory(self) -> float:
        """Resident memory [MB]."""
        status = Path(f"/proc/{self._popen.pid}/status").read_text()
        kilobytes = next(line for line in status.splitlines() if line.startswith("VmRSS:"))
        return int(kilobytes.split()[1]) / 1024

    def new_lines(self) -> List[Any]:
        """The values of the JSON lines printed since the last call."""
        with self._output.open() as file:
            file.seek(self._read)
            whole, newline, _ = file.read().rpartition("\n")
        self._read += len((whole + newline).encode())
        return [json.loads(line) for line in whole.splitlines() if line.startswith("{")]

    def stop(self) -> None:
        """Stops it (SIGSTOP): it neither reads nor answers."""
        self._popen.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Continues it after `stop`."""
        self._popen.send_signal(signal.SIGCONT)

    def wait(self, limit: float) -> None:
        """Waits until it ends.

        Raises:
            FlatlandError: it takes longer than `limit` seconds, or fails.
        """
        try:
            code = self._popen.wait(limit)
        except subprocess.TimeoutExpired:
            raise FlatlandError(f"{self.name} has not ended within {limit:g} s") from None
        if code:
            raise FlatlandError(f"{self.name} has ended with {code}\n{self.report()}")

    def end(self) -> None:
        """Ends it: by SIGTERM, and by SIGKILL if that takes longer than 5 s."""
        if self.has_ended:
            return
        self._popen.terminate()
        self.resume()
        try:
            self._popen.wait(5)
        except subprocess.TimeoutExpired:
            self._popen.kill()
            self._popen.wait()

    def report(self) -> str:
        """Its last lines of output, for error messages."""
        lines = [
            *self._output.read_text(errors="replace").splitlines()[-5:],
            *self._errors.read_text(errors="replace").splitlines()[-20:],
        ]
        return "\n".join(f"{self.name}: {line}" for line in lines)


def cpu_seconds(pid: int) -> float:
    """Processor time that a process has used so far, on all cores."""
    stat = Path(f"/proc/{pid}/stat").read_text()
    user, system = stat.rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / _TICKS


def children() -> List[int]:
    """The processes that the main thread of this one has started."""
    return [int(pid) for pid in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()]


def _die_with_parent() -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def wait_until(
    holds: Callable[[], T], what: str, processes: List[Process], limit: float = 60.0
) -> T:
    """The first true value of `holds()`.

    Raises:
        FlatlandError: it takes too long, or one of the processes has ended.
    """
    deadline = time.monotonic() + limit
    while True:
        value = holds()
        if value:
            return value
        ended = [process.name for process in processes if process.has_ended]
        if ended or time.monotonic() > deadline:
            why = f"{ended[0]} has ended" if ended else f"waited {limit:g} s"
            reports = "\n".join(process.report() for process in processes)
            raise FlatlandError(f"{why}; waited for {what}\n{reports}")
        time.sleep(0.01)
