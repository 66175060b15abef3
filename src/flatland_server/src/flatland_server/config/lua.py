"""Lua expressions in YAML files, evaluated in a sandbox: a process of its own.

`lua_worker` is the program of that process, and says why it is one.
"""

import atexit
import ctypes
import json
import math
import os
import select
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional

TIME_LIMIT = 1.0  # s of processor time for all expressions of a file together
_ANSWER_LIMIT = 30.0  # s of real time until the worker answers, on a busy machine

_MOST_IDLE = 2  # workers that are kept

_WORKER = Path(__file__).with_name("lua_worker.py")


Functions = Mapping[str, Callable[[List[Any]], Any]]


class LuaError(Exception):
    """An expression cannot be evaluated; the message says why."""


class LuaEvaluator:
    """Evaluates expressions, which share a time limit, in a worker process."""

    def __init__(self) -> None:
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
        worker = _take()
        try:
            before = worker.processor_time()
            value = self._evaluate(worker, code, functions, seed, before + self._time_left)
            self._time_left -= worker.processor_time() - before
        except BaseException:
            worker.end()  # its state is unknown; it may have used up its memory
            raise
        _give_back(worker)
        return value

    def _evaluate(
        self, worker: "_Worker", code: str, functions: Functions, seed: int, end: float
    ) -> Any:
        worker.send({"code": code, "seed": seed})
        while True:
            message = worker.receive(end)
            if message is None:
                raise LuaError(self._too_slow())
            if "error" in message:
                raise LuaError(message["error"])
            if "value" in message:
                self.random_count += message["is_random"]
                return message["value"]
            try:
                answer = {"value": functions[message["call"]](message["arguments"])}
            except LuaError as error:
                answer = {"error": str(error)}
            try:
                worker.send(answer)
            except (TypeError, ValueError):
                kind = type(answer["value"]).__name__
                raise LuaError(
                    f"{message['call']}: a value of the type {kind} cannot be passed to Lua"
                ) from None

    def _too_slow(self) -> str:
        message = f"does not end within {TIME_LIMIT:g} s"
        if TIME_LIMIT - self._time_left < 0.01:
            return message
        return f"{message} together with the expressions before it in the file"


class _Worker:
    """A process that evaluates one expression at a time; nothing of one is left for the next.

    Raises:
        LuaError: there is no Lua.
    """

    def __init__(self) -> None:
        import subprocess  # takes 10 ms

        # Started by its file, so that it does not import the package and its dependencies. Isolated
        # (-I), so that it imports nothing from the working directory or from PYTHONPATH.
        command = [sys.executable or "/usr/bin/python3", "-I", str(_WORKER)]
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C in a terminal does not reach it
        )
        self._unread = b""
        # Waits for a first answer, so that starting does not count towards the expression's time.
        self.send({"code": "0", "seed": 0})
        try:
            has_started = self.receive() is not None
        except LuaError:
            has_started = False
        if not has_started:
            self.end()
            check = f"{command[0]} -I -c 'import lupa'"
            raise LuaError(f"Lua does not start: is lupa installed? Try {check}")

    def end(self) -> None:
        """Ends the process."""
        self.process.kill()
        self.process.communicate()

    def send(self, message: Dict[str, Any]) -> None:
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps(message).encode() + b"\n")
            self.process.stdin.flush()
        except OSError:
            pass  # the process has ended; `receive` reports that

    def processor_time(self) -> float:
        """CPU time of the process and this thread [s]: independent of the machine's load."""
        clock = ctypes.c_int()
        if ctypes.CDLL(None).clock_getcpuclockid(self.process.pid, ctypes.byref(clock)) != 0:
            return time.monotonic()
        return time.clock_gettime(clock.value) + time.thread_time()

    def receive(self, end: float = math.inf) -> Optional[Dict[str, Any]]:
        """The next message of the process; None if it does not come in time.

        Args:
            end: the latest `processor_time` at which it may arrive.

        Raises:
            LuaError: the process has ended.
        """
        assert self.process.stdout is not None
        pipe = self.process.stdout.fileno()
        deadline = time.monotonic() + _ANSWER_LIMIT
        while b"\n" not in self._unread:
            remaining = min(end - self.processor_time(), deadline - time.monotonic())
            if remaining <= 0:
                return None
            if not select.select([pipe], [], [], max(remaining, 0.001))[0]:
                continue  # not timed out yet: the worker has waited for a CPU
            chunk = os.read(pipe, 65536)
            if not chunk:
                raise LuaError("takes too much memory")
            self._unread += chunk
        line, self._unread = self._unread.split(b"\n", 1)
        message: Dict[str, Any] = json.loads(line)
        return message


_idle: List[_Worker] = []
"""Workers that wait for an expression, of any evaluator: to start one takes 20 ms."""
_taking = threading.Lock()


def _take() -> _Worker:
    """A worker that is idle, or a new one: one after the other, as others end their work."""
    with _taking:
        while _idle:
            worker = _idle.pop()
            if worker.process.poll() is None:
                return worker
            worker.end()
        return _Worker()


def _give_back(worker: _Worker) -> None:
    """Keeps a worker for the next expression, if there are not many."""
    if len(_idle) < _MOST_IDLE:
        _idle.append(worker)
    else:
        worker.end()


@atexit.register
def _end_idle() -> None:
    while _idle:
        _idle.pop().end()


def _forget() -> None:
    """In a fork: the workers are those of the parent process, and so is a thread with the lock."""
    global _taking
    _idle.clear()
    _taking = threading.Lock()


os.register_at_fork(after_in_child=_forget)
