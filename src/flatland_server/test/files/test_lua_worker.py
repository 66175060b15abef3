"""The process in which $eval is evaluated: how it starts and ends, and what it imports."""

import os
import random
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import pytest
from waiting import wait_until

from flatland_server.config import lua
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import YamlError

IMPORTED_BY_THE_WORKER = ["json", "lupa", "re", "resource", "signal"]


@pytest.fixture(autouse=True)
def idle():
    """The idle workers: none are left of other tests."""
    lua._end_idle()
    yield lua._idle
    lua._end_idle()


@pytest.fixture
def preprocessor():
    return YamlPreprocessor()


@pytest.fixture
def evaluate(preprocessor, files):
    """Evaluates an expression, and returns the text of its value."""

    def evaluate(code: str) -> str:
        path = files.write("file.yaml", f"value: $eval {code}\n")
        return preprocessor.read(path).value[0][1].value

    return evaluate


def plant(folder, modules) -> None:
    """Writes modules that end the process that imports them."""
    folder.mkdir()
    for module in modules:
        (folder / f"{module}.py").write_text("raise SystemExit('imported')")


@pytest.mark.parametrize("place", ["the working directory", "PYTHONPATH"])
def test_the_worker_imports_nothing_from_the_users_folders(good_files, monkeypatch, place):
    planted = good_files.folder / "planted"
    plant(planted, IMPORTED_BY_THE_WORKER)
    if place == "PYTHONPATH":
        monkeypatch.setenv("PYTHONPATH", str(planted))
    else:
        monkeypatch.chdir(planted)
    good_files.edit("world.yaml", "pose: [1, 2, 0.5]", 'pose: "$eval {1, 1 + 1, 0.5}"')

    world = good_files.load()

    assert tuple(world.get_model("robot").pose) == pytest.approx((1, 2, 0.5))


def test_without_lupa_the_error_tells_how_to_check_for_it(files, evaluate, monkeypatch):
    worker = files.write("worker.py", "import no_such_module")
    monkeypatch.setattr(lua, "_WORKER", worker)

    with pytest.raises(YamlError) as caught:
        evaluate("1 + 1")

    assert files.without_folder(str(caught.value)) == (
        "file.yaml:1: $eval: Lua does not start: is lupa installed? "
        f"Try {sys.executable} -I -c 'import lupa', in: 1 + 1"
    )


def test_a_worker_serves_other_files_but_not_a_fork(files, idle):
    path = files.write("file.yaml", "value: $eval 1 + 1\n")
    for _ in range(2):
        YamlPreprocessor().read(path)
    (worker,) = idle

    fork = os.fork()
    if not fork:
        value = lua.LuaEvaluator().evaluate("3", {})
        os._exit(value if idle[0].process.pid != worker.process.pid else 0)
    assert os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1]) == 3
    assert lua.LuaEvaluator().evaluate("4", {}) == 4
    assert idle == [worker]


def test_workers_of_many_threads_are_not_kept(idle):
    barrier = threading.Barrier(lua._MOST_IDLE + 2)
    functions = {"env": lambda _: barrier.wait(60)}
    threads = [
        threading.Thread(target=lambda: lua.LuaEvaluator().evaluate("env()", functions))
        for _ in range(barrier.parties)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert len(idle) == lua._MOST_IDLE


def test_an_expression_leaves_no_garbage_for_the_next(evaluate):
    for _ in range(3):  # each takes more than a third of the memory
        assert evaluate("local t = {} for i = 1, 1.8e6 do t[i] = {} end return 1") == "1"


def has_ended(pid: int) -> bool:
    """True if a process is gone, or waits to be reaped."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] == "Z"


def wait_until_ended(pid: int) -> None:
    wait_until(lambda: has_ended(pid), f"the process {pid} to end", 10.0)


def wait_until_computing(pid: int) -> None:
    """Waits until a process has used a tenth of a second of processor time from now on."""

    def ticks() -> int:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return int(fields[11]) + int(fields[12])

    end = ticks() + 0.1 * os.sysconf("SC_CLK_TCK")
    wait_until(lambda: ticks() >= end, f"the process {pid} to compute", 10.0)


def test_a_busy_worker_ends_when_its_parent_is_killed():
    program = """
        import sys
        from flatland_server.config import lua
        lua.TIME_LIMIT = 60.0
        lua._give_back(lua._take())
        functions = {"env": lambda _: print(worker.process.pid, flush=True)}
        worker = lua._idle[0]
        lua.LuaEvaluator().evaluate("env() while true do end", functions)
    """
    parent = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program)], stdout=subprocess.PIPE
    )
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    wait_until_computing(worker)

    parent.kill()

    parent.communicate()
    wait_until_ended(worker)


def test_the_worker_outlives_the_thread_that_has_started_it(idle):
    evaluator = lua.LuaEvaluator()
    thread = threading.Thread(target=lambda: evaluator.evaluate("1", {}))
    thread.start()
    thread.join()
    (worker,) = idle
    time.sleep(0.1)

    assert evaluator.evaluate("2", {}) == 2
    assert idle == [worker]  # not another one


def test_the_worker_has_no_files_processes_or_endless_time(evaluate, idle):
    evaluate("1")

    limits = Path(f"/proc/{idle[0].process.pid}/limits").read_text()

    soft = {line[:26].strip(): line[26:].split()[0] for line in limits.splitlines()[1:]}
    assert soft["Max open files"] == "0"
    assert soft["Max processes"] == "0"
    assert soft["Max file size"] == "0"
    assert int(soft["Max cpu time"]) < 10


@pytest.mark.slow
def test_the_kernel_ends_a_worker_that_computes_for_too_long():
    worker = subprocess.Popen(
        [sys.executable, "-I", lua._WORKER, str(os.getpid())],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert worker.stdin is not None
    worker.stdin.write(b'{"code": "while true do end", "seed": 0}\n')
    worker.stdin.flush()

    assert worker.wait(60) == -signal.SIGXCPU
    worker.communicate()


def test_the_expressions_of_a_file_share_their_time(files, preprocessor, monkeypatch):
    monkeypatch.setattr(lua, "TIME_LIMIT", 0.2)
    slow = "$eval local t = 0 for i = 1, 1e6 do t = t + math.sin(i) end return t"
    path = files.write("file.yaml", "".join(f"x{i}: {slow}\n" for i in range(60)))

    with pytest.raises(YamlError) as caught:
        preprocessor.read(path)

    assert "together with the expressions before it in the file" in str(caught.value)


def test_each_file_has_its_own_time_limit(evaluate, monkeypatch):
    monkeypatch.setattr(lua, "TIME_LIMIT", 0.1)
    with pytest.raises(YamlError):
        evaluate("while true do end")

    assert evaluate("1 + 1") == "2"


def test_without_expressions_there_is_no_worker(files, preprocessor, idle):
    preprocessor.read(files.write("file.yaml", "value: 1\n"))

    assert idle == []


def test_a_killed_worker_is_replaced(evaluate, idle):
    evaluate("1")
    killed = idle[0].process
    killed.kill()
    wait_until_ended(killed.pid)

    assert evaluate("2") == "2"
    assert killed.returncode == -signal.SIGKILL


def test_random_numbers_are_the_same_with_every_lua():
    """LuaJIT, and Lua on another C library, have other generators."""
    code = "{math.random(), math.random(6), math.random(-5, -2)}"
    found = lua.LuaEvaluator().evaluate(code, {}, 5)

    generator = random.Random(5)
    draws = [generator.random() for _ in range(3)]
    assert found == [draws[0], 1 + int(draws[1] * 6), -5 + int(draws[2] * 4)]
