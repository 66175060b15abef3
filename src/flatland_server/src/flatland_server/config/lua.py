"""Lua expressions in YAML files, evaluated in a sandbox: a process of its own.

`lua_worker` is the program of that process, and says why it is one.
"""

import ctypes
import json
import math
import os
import select
import sys
import time
import weakref
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional

if TYPE_CHECKING:
    import subprocess

TIME_LIMIT = 1.0  # s of processor time for all expressions of a file together
_ANSWER_LIMIT = 30.0  # s of real time until the worker answers, on a busy machine

_WORKER = Path(__file__).with_name("lua_worker.py")


Functions = Mapping[str, Callable[[List[Any]], Any]]


class LuaError(Exception):
    """An expression cannot be evaluated; the message says why."""


class LuaEvaluator:
    """Evaluates expressions in a worker process, which is started for the first one.

    The process ends with this object.
    """

    def __init__(self) -> None:
        self._worker: Optional[subprocess.Popen[bytes]] = None
        self._unread = b""
        self._time_left = TIME_LIMIT
        self.random_count = 0
        """The number of expressions so far that have called math.random."""

    def restart_time(self) -> None:
        """Restarts the time limit, which holds for the expressions of one file."""
        self._time_left = TIME_LIMIT

    def evaluate(self, code: str, functions: Functions, seed: int = 0) -> Any:
        """Evaluates an expression, or a chunk of code that returns a value.

        Args:
            code: of Lua.
            functions: its functions `env` and `param`, by name. They get a list of arguments, and
                raise a LuaError to make the expression fail.
            seed: of math.random, from 0 to 2**31 - 1.

        Returns:
            None, a bool, a number, a string, or a list or dict of these.

        Raises:
            LuaError: the code is not Lua, fails, does not end in time or takes too much memory; or
                there is no Lua. The time is that of all calls since `restart_time`.
        """
        if self._worker is None:
            self._start()
        before = self._processor_time()
        value = self._evaluate(code, functions, seed, before + self._time_left)
        self._time_left -= self._processor_time() - before
        return value

    def _evaluate(self, code: str, functions: Functions, seed: int, end: float) -> Any:
        self._send({"code": code, "seed": seed})
        while True:
            message = self._receive(end)
            if "error" in message:
                self.close()  # its state is unknown; it may have used up its memory
                raise LuaError(message["error"])
            if "value" in message:
                self.random_count += message["is_random"]
                return message["value"]
            try:
                answer = {"value": functions[message["call"]](message["arguments"])}
            except LuaError as error:
                answer = {"error": str(error)}
            try:
                self._send(answer)
            except (TypeError, ValueError):
                self.close()
                kind = type(answer["value"]).__name__
                raise LuaError(
                    f"{message['call']}: a value of the type {kind} cannot be passed to Lua"
                ) from None

    def close(self) -> None:
        """Ends the worker process, if there is one."""
        if self._worker is not None:
            self._worker = None
            self._end()

    def _too_slow(self) -> str:
        message = f"does not end within {TIME_LIMIT:g} s"
        if TIME_LIMIT - self._time_left < 0.01:
            return message
        return f"{message} together with the expressions before it in the file"

    def _start(self) -> None:
        import subprocess  # takes 10 ms

        self._unread = b""
        # Started by its file, so that it does not import the package and its dependencies. Isolated
        # (-I), so that it imports nothing from the working directory or from PYTHONPATH.
        command = [sys.executable or "/usr/bin/python3", "-I", str(_WORKER)]
        self._worker = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C in a terminal does not reach it; `close` ends it
        )
        self._end = weakref.finalize(self, _end, self._worker, os.getpid())
        # Waits for a first answer, so that starting does not count towards the expression's time.
        self._send({"code": "0", "seed": 0})
        try:
            self._receive()
        except LuaError:
            check = f"{command[0]} -I -c 'import lupa'"
            raise LuaError(f"Lua does not start: is lupa installed? Try {check}") from None

    def _send(self, message: Dict[str, Any]) -> None:
        assert self._worker is not None
        assert self._worker.stdin is not None
        try:
            self._worker.stdin.write(json.dumps(message).encode() + b"\n")
            self._worker.stdin.flush()
        except OSError:
            pass  # the worker has ended; `_receive` reports that

    def _processor_time(self) -> float:
        """CPU time of the worker and this thread [s]: independent of the machine's load."""
        assert self._worker is not None
        clock = ctypes.c_int()
        if ctypes.CDLL(None).clock_getcpuclockid(self._worker.pid, ctypes.byref(clock)) != 0:
            return time.monotonic()
        return time.clock_gettime(clock.value) + time.thread_time()

    def _receive(self, end: float = math.inf) -> Dict[str, Any]:
        """The next message of the worker.

        Args:
            end: the latest `_processor_time` at which it may arrive.

        Raises:
            LuaError: it does not come in time, or the worker has ended.
        """
        assert self._worker is not None
        assert self._worker.stdout is not None
        pipe = self._worker.stdout.fileno()
        deadline = time.monotonic() + _ANSWER_LIMIT
        while b"\n" not in self._unread:
            remaining = min(end - self._processor_time(), deadline - time.monotonic())
            if remaining <= 0:
                self.close()
                raise LuaError(self._too_slow())
            if not select.select([pipe], [], [], max(remaining, 0.001))[0]:
                continue  # not timed out yet: the worker has waited for a CPU
            chunk = os.read(pipe, 65536)
            if not chunk:
                self.close()
                raise LuaError("takes too much memory")
            self._unread += chunk
        line, self._unread = self._unread.split(b"\n", 1)
        message: Dict[str, Any] = json.loads(line)
        return message


def _end(worker: "subprocess.Popen[bytes]", process: int) -> None:
    """Ends a worker; does nothing in a fork of the process that has started it."""
    if os.getpid() == process:
        worker.kill()
        worker.communicate()
