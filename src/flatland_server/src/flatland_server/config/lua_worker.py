"""The program that evaluates Lua for `flatland_server.config.lua`, with limited memory.

World files are data, not programs: an expression has access to the tables and functions named below
and to nothing else. It is evaluated in a separate process because an endless loop within one of
Lua's own functions (a pattern that backtracks, a string repeated a billion times) can only be
stopped by killing the process.

The process has little memory and processor time, cannot open a file or a socket, cannot start
another process, and ends with its input, at the latest after that time. (A filter of system calls
would also stop the few that need none of these, such as deleting a file; but it needs a table of
their numbers for each processor, and an expression has no means to make a system call.)

The protocol is JSON, one message per line. Input: `{"code": ..., "seed": ...}`. Output:
`{"value": ..., "is_random": ...}`, `{"error": ...}`, or `{"call": "env" | "param", "arguments":
[...]}`, to which the parent process replies with `{"value": ...}` or `{"error": ...}`.
"""

import json
import re
import resource
import sys
import time
from _random import Random  # `random` imports more than all of this program
from typing import Any, Dict, List

try:
    from lupa import lua51 as lupa  # PyPI's has several Luas; the sandbox is for ROS's, 5.1
except ImportError:
    import lupa

MEMORY_LIMIT = 256 * 1024 * 1024  # bytes of address space, in addition to the interpreter's own
CPU_LIMIT = 2  # s of processor time, at most, per expression; the parent limits its real time
_MAX_VALUES = 10_000  # in a table that is returned
_MAX_DEPTH = 50  # of nested tables

# Everything that an expression has access to. Each expression gets new tables. `env` and `param`
# are Lua functions that wrap a Python one, so that expressions have access to no Python object.
_SANDBOX = """
local ask_python, draw, set_seed = ...
local load_text, set_globals, count, raise = loadstring, setfenv, select, error
local floor, is_random = math.floor, false
local names = {"tonumber", "tostring", "type", "pairs", "ipairs", "next", "select", "unpack",
               "assert", "error"}
local libraries = {math = math, string = string, table = table}
local all = _G

local function asker(name)
  return function(...) return ask_python(name, count("#", ...), ...) end
end

local function globals()
  local visible = {env = asker("env"), param = asker("param")}
  for _, name in ipairs(names) do visible[name] = all[name] end
  for name, library in pairs(libraries) do
    visible[name] = {}
    for key, value in pairs(library) do visible[name][key] = value end
  end
  visible.string.dump = nil
  visible.math.randomseed = function(seed) set_seed(seed) end
  visible.math.random = function(low, high)
    is_random = true
    if not low then return draw() end
    if not high then low, high = 1, low end
    if low > high then raise("math.random: the interval is empty", 0) end
    return low + floor(draw() * (high - low + 1))
  end
  return setmetatable(visible, {__index = function(_, name)
    raise('"' .. tostring(name) .. '" is not available in $eval', 0)
  end})
end

return function(code, seed)
  -- The "=" keeps the code out of messages. A string that begins with an escape is bytecode.
  if code:sub(1, 1) == "\\27" then raise("bytecode is not allowed", 0) end
  local chunk, problem = load_text("return " .. code, "=$eval")
  if not chunk then chunk, problem = load_text(code, "=$eval") end
  if not chunk then raise(problem, 0) end
  set_seed(seed)
  is_random = false
  return (set_globals(chunk, globals())()), is_random
end
"""


def _deny(_object: Any, _name: Any, _is_setting: bool) -> Any:
    raise AttributeError("Python is not available in $eval")


class Worker:
    """A Lua interpreter with a sandbox, which serves the parent process."""

    def __init__(self) -> None:
        self._lua = lupa.LuaRuntime(
            attribute_filter=_deny,
            register_eval=False,
            register_builtins=False,
            unpack_returned_tuples=True,
        )
        # Not Lua's own: that of LuaJIT, and of another C library, gives other numbers.
        self._random = Random()
        self._evaluate = self._lua.execute(
            _SANDBOX, self._call, self._random.random, self._set_seed
        )

        self._collect_garbage = self._lua.eval("collectgarbage")

    def serve(self) -> None:
        """Evaluates expressions until standard input ends."""
        for line in sys.stdin:
            _limit_cpu_time()
            try:
                message = json.loads(line)
                value, is_random = self._evaluate(message["code"], message["seed"])
                value = self._to_python(value, [_MAX_VALUES])
                _send({"value": value, "is_random": is_random})
            except MemoryError:
                _send({"error": "not enough memory"})
            except Exception as error:
                _send({"error": _message(error)})
            self._collect_garbage()  # Lua 5.1 does not when its memory is used up

    def _set_seed(self, seed: float) -> None:
        self._random.seed(int(seed))

    def _call(self, name: str, count: float, *arguments: Any) -> Any:
        given = list(arguments) + [None] * (int(count) - len(arguments))
        _send({"call": name, "arguments": [self._to_python(a, [_MAX_VALUES]) for a in given]})
        answer = json.loads(sys.stdin.readline())
        if "error" in answer:
            raise ValueError(answer["error"])
        return self._to_lua(answer["value"])

    def _to_lua(self, value: Any) -> Any:
        if isinstance(value, dict):
            return self._lua.table_from({k: self._to_lua(v) for k, v in value.items()})
        if isinstance(value, list):
            return self._lua.table_from([self._to_lua(v) for v in value])
        return value

    def _to_python(self, value: Any, left: List[int], depth: int = 0) -> Any:
        """Converts a value of Lua to None, a bool, number, string, list or dict.

        Args:
            value: the value in Lua.
            left: its only item is the number of values still allowed; counted down.
            depth: number of tables around the value.

        Raises:
            ValueError: it cannot be converted, or is too large.
        """
        left[0] -= 1
        if left[0] < 0:
            raise ValueError("the table that is returned is too large")
        if depth > _MAX_DEPTH:
            raise ValueError("a table is nested too deeply, or contains itself")
        kind = lupa.lua_type(value)
        if kind is None and (value is None or isinstance(value, (bool, int, float, str))):
            return value
        if kind != "table":
            raise ValueError(f"expected a number, boolean, string or table, found a {kind}")
        items: Dict[Any, Any] = dict(value.items())
        if all(isinstance(key, (int, float)) for key in items):
            if sorted(items) != list(range(1, len(items) + 1)):
                raise ValueError("expected a table with keys 1, 2, 3 ..., found gaps")
            return [self._to_python(items[i], left, depth + 1) for i in range(1, len(items) + 1)]
        if not all(isinstance(key, str) for key in items):
            raise ValueError("expected a table with names or with numbers as keys, found both")
        return {key: self._to_python(item, left, depth + 1) for key, item in items.items()}


def _message(error: Exception) -> str:
    """The message of an error of Lua or the sandbox, without a traceback or a place in the code."""
    first_line = (str(error).splitlines() or [""])[0]
    text = re.sub(r'^(\$eval|\[string ".*?"\]):\d+: ', "", first_line).strip()
    return text or "it fails without a message"


def _send(message: Dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


def _limit_resources() -> None:
    """Limits memory, files and processes to the needs of evaluating an expression."""
    with open("/proc/self/statm") as file:  # importing pathlib: an eighth of the start
        pages = int(file.read().split()[0])
    memory = pages * resource.getpagesize() + MEMORY_LIMIT
    limits = {
        resource.RLIMIT_AS: memory,
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_FSIZE: 0,  # bytes written to a file
        resource.RLIMIT_NOFILE: 0,  # files and sockets that are opened from now on
        resource.RLIMIT_NPROC: 0,  # processes that are started from now on, unless by root
    }
    for limit, value in limits.items():
        resource.setrlimit(limit, (value, value))


def _limit_cpu_time() -> None:
    """Makes the kernel kill this process if it computes for longer than `CPU_LIMIT` from now on."""
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    soft = int(time.process_time()) + CPU_LIMIT
    resource.setrlimit(
        resource.RLIMIT_CPU, (soft if hard == resource.RLIM_INFINITY else min(soft, hard), hard)
    )


def main() -> None:
    """Serves the parent process by standard input and output."""
    worker = Worker()
    _limit_resources()
    worker.serve()


if __name__ == "__main__":
    main()
