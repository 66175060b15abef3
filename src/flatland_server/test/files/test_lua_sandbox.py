"""The sandbox of $eval: each known attack fails soon, with a YamlError that names it."""

import datetime
import os
import xmlrpc.client
from typing import Any, Tuple

import pytest

from flatland_server.config import lua
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import YamlError

pytestmark = pytest.mark.slow


class Unprintable:
    """A parameter of a type that no file format knows."""


ODD_PARAMS = {
    "/binary": xmlrpc.client.Binary(b"\x00\xff"),
    "/bytes": b"\x00\xff",
    "/date": datetime.datetime(2020, 1, 1),
    "/set": {1, 2},
    "/object": Unprintable(),
    "/function": len,
    "/nested": {"a": [len]},
    "/keys": {(1, 2): 3},
    "/surrogate": "\ud800",
}


def get_param(path: str, default: Any) -> Any:
    if path == "/failing":
        raise OSError("the master is gone")
    return ODD_PARAMS.get(path, default)


@pytest.fixture(scope="module")
def preprocessor():
    return YamlPreprocessor(get_param)


@pytest.fixture
def evaluate(preprocessor, files):
    """Evaluates an expression, and returns the text of its value."""

    def evaluate(code: str) -> Any:
        indented = code.replace("\n", "\n  ")
        path = files.write("attack.yaml", f"value: |-\n  $eval {indented}\n".encode())
        return preprocessor.read(path).value[0][1].value

    return evaluate


def outcome(evaluate, code: str) -> Tuple[Any, str]:
    """The value of an expression and an empty string, or None and the error."""
    try:
        return evaluate(code), ""
    except YamlError as error:
        return None, str(error)


def processor_time() -> float:
    """Processor time of this process and of its children that have ended [s]."""
    return sum(os.times()[:4])


def assert_next_one_works(evaluate) -> None:
    begin = processor_time()
    assert evaluate("string.rep('ab', 2) .. math.max(1, 2) .. table.concat({3})") == "abab23"
    assert processor_time() - begin < 2.0


UNAVAILABLE = [
    # Python
    "python", "python.builtins", "python.eval('1')", "python.execute('import os')",
    "python.as_attrgetter({})", "lupa", "builtins", "__import__('os')",
    # The operating system
    "io.open('/etc/passwd')", "io.popen('id')", "io.lines('/etc/passwd')", "os.execute('id')",
    "os.exit(0)", "os.getenv('HOME')", "os.remove('/tmp/x')", "os.tmpname()", "print('x')",
    "package.loadlib('libc.so.6', 'system')", "package.loaded.os", "package.preload",
    "require('os')", "require 'ffi'", "module('x')", "ffi.C.system('id')", "jit.off()",
    "bit.bor(1)", "arg[0]",
    # Code from strings and files
    "load('return 1')", "loadstring('return 1')()", "loadfile('/etc/passwd')",
    "dofile('/etc/passwd')", "load(string.rep)",
    # Reflection
    "debug.getregistry()", "debug.sethook()", "debug.getupvalue(env, 1)", "_G", "_G._G", "_ENV",
    "_VERSION", "getfenv(0)", "getfenv(1)", "setfenv(1, {})", "getmetatable('')",
    "getmetatable('').__index", "setmetatable({}, {})", "rawget({}, 1)", "rawset({}, 1, 2)",
    "rawequal(1, 1)", "rawlen({})", "newproxy(true)", "collectgarbage('count')", "gcinfo()",
    "coroutine.create(env)", "coroutine.wrap(env)()", "pcall(error)", "xpcall(error, error)",
    "ask_python('env')", "all", "libraries",
]  # fmt: skip


@pytest.mark.parametrize("code", UNAVAILABLE)
def test_dangerous_lua_functions_are_not_available(evaluate, files, code):
    name = code.split("(")[0].split(".")[0].split(" ")[0].split("[")[0]

    with pytest.raises(YamlError) as caught:
        evaluate(code)

    assert files.without_folder(str(caught.value)) == (
        f'attack.yaml:1: $eval: "{name}" is not available in $eval, in: {code}'
    )
    assert_next_one_works(evaluate)


FAILING = {
    # effect: the code, part of the error's text
    "reads an attribute of env": ("env.__globals__", "attempt to index global 'env'"),
    "reads an attribute of param": ("param.__self__", "attempt to index global 'param'"),
    "sets an attribute of env": ("env.x = 1", "attempt to index global 'env'"),
    "returns env": ("env", "expected a number, boolean, string or table, found a function"),
    "returns math": ("math", "expected a number, boolean, string or table, found a function"),
    "returns string.rep": ("string.rep", "found a function"),
    "returns a method": ("('').dump", None),
    "returns math.random": ("math.random", "found a function"),
    "gives env to env": ("env(env)", "found a function"),
    "gives env a table": ("env({})", "expected env(name) or env(name, default)"),
    "gives env nothing": ("env()", "expected env(name) or env(name, default)"),
    "gives env too much": ("env('a', 1, 2)", "expected env(name) or env(name, default)"),
    "gives env a number": ("env(1)", "expected env(name) or env(name, default)"),
    "gives env a function for a default": ("env('NOT_SET', print)", '"print" is not available'),
    "gives param a table": ("param({})", "expected param(name) or param(name, default)"),
    "gives param a function": ("param('/x', env)", "found a function"),
    "gives param a table with itself": ("local t = {} t[1] = t return param(t)", "contains itself"),
    "asks for a parameter while the master is gone": (
        "param('/failing')",
        'the parameter "/failing" cannot be read: the master is gone',
    ),
    "dumps a function": ("string.dump(env)", "attempt to call field 'dump' (a nil value)"),
    "is bytecode": ("\x1bLJ\x02", None),
    "is bytecode behind a comment": ("return '\\27LJ'()", None),
    "throws a table": ("error({})", None),
    "throws a function": ("error(env)", None),
    "throws nothing": ("error()", None),
    "throws an empty string": ("error('')", None),
    "throws a string of several lines": ("error('first\\nsecond')", "first"),
    "throws a table that pretends": ("error({value = 1})", None),
    "fails an assertion": ("assert(false, 'no')", "no"),
    "ends the chunk early": ("1 end return 2", None),
    "closes a function that is not there": ("end)() os.exit() (function()", None),
    "indexes nothing": ("nil.x", None),
    "calls a number": ("(1)()", None),
    "compares what cannot be": ("{} < {}", None),
    "is a goto into nothing": ("goto out", None),
    "returns a table that contains itself": ("local t = {} t.t = t return t", "contains itself"),
    "returns a table in a table in a table ...": (
        "local t = {} for _ = 1, 5000 do t = {t} end return t",
        None,
    ),
    "returns a table with a function in it": ("{1, env}", "found a function"),
    "returns a table with a table as a key": ("{[{}] = 1}", None),
    "returns a table with names and numbers": ("{1, x = 2}", "names or with numbers as keys"),
    "returns too large a table": (
        "local t = {} for i = 1, 1e5 do t[i] = i end return t",
        "is too large",
    ),
    "returns bytes that are no text": ("'\\255\\254'", None),
    "unpacks without end": ("unpack({}, 1, 1e8)", None),
    "recurses without end": ("local function f() return 1 + f() end return f()", "stack overflow"),
    "formats what it does not get": ("string.format('%d')", None),
    "formats endlessly wide": ("string.format('%999999999d', 1)", None),
    "selects beyond": ("select(-1e9)", None),
    "opens a thousand brackets": ("(" * 1000 + "1" + ")" * 1000, None),
    "changes a global's metatable": ("('').x.y = 1", None),
    "sets a key of all strings": ("('').upper = 1", None),
    "sorts by what is no order": ("table.sort({3, 1, 2}, 1)", None),
    "sorts with what is no order": (
        "local t = {} for i = 1, 5e6 do t[i] = i end\n"
        "table.sort(t, function(a, b) return true end) return 1",
        None,
    ),
    # Memory; on a slow machine, slow cases may run out of time first.
    "repeats a string": ("('x'):rep(2^31 - 1)", "not enough memory"),
    "doubles a string": ("local s = 'x' while true do s = s .. s end", None),
    "fills a table": ("local t = {} while true do t[#t + 1] = {} end", None),
    "fills a table with numbers": ("local t = {} for i = 1, 1e9 do t[i] = i end", None),
    "fills a table with strings": (
        "local t = {} for i = 1, 1e9 do t[i] = ('x'):rep(1e6) .. i end",
        None,
    ),
    "concatenates endlessly": (
        "local t = {} for i = 1, 1e4 do t[i] = ('x'):rep(1e5) end return #table.concat(t)",
        None,
    ),
    "replaces endlessly": ("('x'):rep(1e5):gsub('x', ('y'):rep(1e5))", None),
}


ENDLESS = {
    "loops": "while true do end",
    "loops in a repeat": "repeat until false",
    "loops with goto": "::a:: goto a",
    "loops in a for": "for i = 1, 1e18 do end",
    "loops in a tail call": "local function f() return f() end return f()",
    "loops in an iterator": "for _ in function() return 1 end do end",
    "backtracks in a pattern": "('a'):rep(500):find(('a*'):rep(50) .. 'b')",
    "backtracks in gsub": "('a'):rep(2000):gsub(('.-'):rep(20) .. 'b', '')",
    "sorts slowly": "table.sort({2, 1}, function(a, b) while true do end end) return 1",
    "asks for ever": "while true do env('PATH') end",
}


@pytest.mark.slow
@pytest.mark.parametrize(("code", "message"), FAILING.values(), ids=FAILING.keys())
def test_an_attack_fails_with_an_error_that_names_it(evaluate, files, code, message):
    with pytest.raises(YamlError) as caught:
        evaluate(code)

    text = files.without_folder(str(caught.value))
    assert text.startswith("attack.yaml")
    if message is not None:
        assert text.startswith("attack.yaml:1: $eval: ")
        assert message in text
        assert ", in: " in text
    assert "Traceback" not in text
    assert ": , in:" not in text, "an error without a reason"
    assert_next_one_works(evaluate)


@pytest.mark.parametrize("code", ENDLESS.values(), ids=ENDLESS.keys())
def test_an_endless_expression_is_ended(evaluate, files, monkeypatch, code):
    limit = lua.TIME_LIMIT if code == ENDLESS["loops"] else 0.1  # processor time for each
    monkeypatch.setattr(lua, "TIME_LIMIT", limit)
    begin = processor_time()

    with pytest.raises(YamlError) as caught:
        evaluate(code)

    assert 0.9 * limit < processor_time() - begin < limit + 1.0
    text = files.without_folder(str(caught.value))
    assert text.startswith(f"attack.yaml:1: $eval: does not end within {limit:g} s, in: ")
    assert_next_one_works(evaluate)


@pytest.mark.parametrize(
    "name", ["", " ", "A=B", "\\0", "PATH\\0X", "$(id)", "`id`", "../x", "\\n", "é", "\\255"]
)
def test_odd_names_of_environment_variables_are_only_names(evaluate, name):
    value, problem = outcome(evaluate, f"env('{name}', 'not set')")

    assert value == "not set" or "$eval: " in problem
    assert_next_one_works(evaluate)


@pytest.mark.parametrize("name", [*ODD_PARAMS, "not UTF-8"])
def test_a_value_of_an_odd_type_is_an_error_or_a_string(evaluate, monkeypatch, name):
    monkeypatch.setitem(os.environ, "FLATLAND_ATTACK", os.fsdecode(b"\xff\xfe"))
    code = f"param('{name}')" if name in ODD_PARAMS else "env('FLATLAND_ATTACK')"
    value, problem = outcome(evaluate, code)

    assert isinstance(value, (str, list)) or code in problem
    assert_next_one_works(evaluate)


@pytest.mark.parametrize("value", ["$(id)", "python.eval('1')", "]] .. os.exit() .. [[", "\x1bLua"])
def test_the_text_of_an_environment_variable_is_not_evaluated(evaluate, monkeypatch, value):
    monkeypatch.setenv("FLATLAND_ATTACK", value)

    assert evaluate("env('FLATLAND_ATTACK')") == value


@pytest.mark.parametrize("result", ["$eval os.exit()", "$include /etc/passwd", "$[include] x"])
def test_the_result_of_an_expression_is_not_resolved_again(evaluate, result):
    assert evaluate(f"'{result}'") == result


@pytest.mark.parametrize(
    "poison",
    [
        "string.rep = nil",
        "math.max = function() return 99 end",
        "table.concat = env",
        "string = nil",
        "tostring = nil tonumber = nil type = nil pairs = nil next = nil",
        "env = nil param = nil",
        "for k in pairs(string) do string[k] = nil end",
        "for k in pairs(math) do math[k] = nil end",
        "error = env; select = env; unpack = env; assert = env",
        "python = 1; io = 2; os = 3; _G = 4",
    ],
)
def test_globals_overwritten_by_an_expression_are_restored(evaluate, poison):
    assert evaluate(f"{poison} return 1") == "1"

    assert_next_one_works(evaluate)
    assert evaluate("type(env) .. tostring(1) .. select('#', next({1}))") == "function12"
    with pytest.raises(YamlError):
        evaluate("os")
