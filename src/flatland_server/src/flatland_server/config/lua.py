"""Lua expressions of YAML files, evaluated out of reach of everything else."""

import json
import os
import select
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

TIME_LIMIT = 1.0  # s per expression

_WORKER = Path(__file__).with_name("lua_worker.py")


class LuaError(Exception):
    """An expression that cannot be evaluated, and why."""


class LuaEvaluator:
    """Evaluates expressions in a process of its own, which is started when it is needed.

    Args:
        functions: what `env` and `param` do, by name. They get the arguments as a list.
    """

    def __init__(self, functions: Dict[str, Callable[[List[Any]], Any]]) -> None:
        self._functions = functions
        self._worker: Optional[subprocess.Popen[bytes]] = None
        self._unread = b""

    def evaluate(self, code: str) -> Any:
        """The value of an expression, or what a chunk of code returns.

        Returns:
            None, a bool, a number, a string, or a list or dict of these.

        Raises:
            LuaError: it is not Lua, fails, does not end in time, or takes too much memory.
        """
        if self._worker is None:
            self._start()
        deadline = time.monotonic() + TIME_LIMIT
        self._send({"code": code})
        while True:
            message = self._receive(deadline)
            if "error" in message:
                self.close()  # whatever state it is in; memory that is used up, for one
                raise LuaError(message["error"])
            if "value" in message:
                return message["value"]
            try:
                answer = {"value": self._functions[message["call"]](message["arguments"])}
            except LuaError as error:
                answer = {"error": str(error)}
            try:
                self._send(answer)
            except (TypeError, ValueError):
                self.close()
                kind = type(answer["value"]).__name__
                raise LuaError(
                    f"{message['call']}: Lua has nothing for a value of the type {kind}"
                ) from None

    def close(self) -> None:
        """Ends the process, if there is one."""
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.kill()
            worker.communicate()

    def _start(self) -> None:
        self._unread = b""
        self._worker = subprocess.Popen(
            # By its file, so that no package is imported; isolated (-I), so that neither the
            # working directory nor PYTHONPATH has a say in what is.
            [sys.executable or "/usr/bin/python3", "-I", str(_WORKER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the simulator; it ends the worker itself
        )
        # A first answer shows that it is there: starting does not count as the expression's time.
        self._send({"code": "true"})
        self._receive(time.monotonic() + 30.0)

    def _send(self, message: Dict[str, Any]) -> None:
        assert self._worker is not None
        assert self._worker.stdin is not None
        try:
            self._worker.stdin.write(json.dumps(message).encode() + b"\n")
            self._worker.stdin.flush()
        except OSError:
            pass  # it has died; `_receive` says so

    def _receive(self, deadline: float) -> Dict[str, Any]:
        assert self._worker is not None
        assert self._worker.stdout is not None
        pipe = self._worker.stdout.fileno()
        while b"\n" not in self._unread:
            remaining = deadline - time.monotonic()
            if remaining <= 0 or not select.select([pipe], [], [], remaining)[0]:
                self.close()
                raise LuaError(f"does not end within {TIME_LIMIT:g} s")
            chunk = os.read(pipe, 65536)
            if not chunk:
                self.close()
                raise LuaError("takes too much memory")
            self._unread += chunk
        line, self._unread = self._unread.split(b"\n", 1)
        message: Dict[str, Any] = json.loads(line)
        return message
