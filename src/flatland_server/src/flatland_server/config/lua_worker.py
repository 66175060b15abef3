"""Evaluates Lua for `flatland_server.config.lua`, in a process of its own with little memory.

World files are data, not programs: an expression gets the tables and functions named below and
nothing else. It runs here, and not in the simulator, because an endless loop within one of Lua's
own functions (a pattern that backtracks, a string repeated a billion times) can only be ended with
its process.

Speaks JSON, a message a line. In: `{"code": ...}`. Out: `{"value": ...}`, `{"error": ...}`, or
`{"call": "env" | "param", "arguments": [...]}`, which is answered with `{"value": ...}`.
"""

import json
import re
import resource
import sys
from pathlib import Path
from typing import Any, Dict, List

import lupa

MEMORY_LIMIT = 256 * 1024 * 1024  # bytes of address space, beyond what the interpreter itself takes
_MAX_VALUES = 10_000  # in a table that is returned
_MAX_DEPTH = 50  # of tables in tables

# Everything that an expression can see; its globals are a new table each time. `env` and `param`
# are Lua functions around Python ones, so that no Python object is within reach.
_SANDBOX = """
local ask_python = ...
local load_text, set_globals, count, raise = loadstring, setfenv, select, error
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
  return setmetatable(visible, {__index = function(_, name)
    raise('"' .. tostring(name) .. '" is not available in $eval', 0)
  end})
end

return function(code)
  -- The "=" keeps the code out of the messages; a text that begins with an escape is bytecode.
  if code:sub(1, 1) == "\\27" then raise("bytecode is not allowed", 0) end
  local chunk, problem = load_text("return " .. code, "=$eval")
  if not chunk then chunk, problem = load_text(code, "=$eval") end
  if not chunk then raise(problem, 0) end
  return (set_globals(chunk, globals())())
end
"""


def _deny(_object: Any, _name: Any, _is_setting: bool) -> Any:
    raise AttributeError("Python is out of reach")


class Worker:
    """Lua with a sandbox, and the conversation about it."""

    def __init__(self) -> None:
        self._lua = lupa.LuaRuntime(
            attribute_filter=_deny,
            register_eval=False,
            register_builtins=False,
            unpack_returned_tuples=True,
        )
        self._evaluate = self._lua.execute(_SANDBOX, self._ask)

    def serve(self) -> None:
        """Answers until the input ends."""
        for line in sys.stdin:
            try:
                value = self._to_python(self._evaluate(json.loads(line)["code"]), [_MAX_VALUES])
                _say({"value": value})
            except MemoryError:
                _say({"error": "not enough memory"})
            except Exception as error:
                _say({"error": _message(error)})

    def _ask(self, name: str, count: float, *arguments: Any) -> Any:
        given = list(arguments) + [None] * (int(count) - len(arguments))
        _say({"call": name, "arguments": [self._to_python(a, [_MAX_VALUES]) for a in given]})
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
        """A number, bool, string, None, list or dict; `left` counts down the values that may be."""
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
    """What Lua or the sandbox says, without its traceback and place: YAML knows better."""
    first_line = (str(error).splitlines() or [""])[0]
    text = re.sub(r'^(\$eval|\[string ".*?"\]):\d+: ', "", first_line).strip()
    return text or "it fails without a message"


def _say(message: Dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Serves a parent process over standard input and output."""
    worker = Worker()
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MEMORY_LIMIT
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    worker.serve()


if __name__ == "__main__":
    main()
