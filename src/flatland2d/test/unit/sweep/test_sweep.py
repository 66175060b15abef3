"""flatland sweep: its output, interruptions, and the failures that it survives."""

import base64
import csv
import importlib.util
import json
import os
import re
import signal
import subprocess
import sys
import threading
import urllib.request
from dataclasses import replace
from pathlib import Path

import pytest
from waiting import wait_until

from flatland2d.cli import main
from flatland2d.sweep import ray_pool
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.settings import scenarios_of
from flatland2d.sweep.sweep import Journal

pytestmark = pytest.mark.slow

NOTES = {"forks": "own"}
QUICK = {"step_size": 0.02, "control_period": 0.1}
TABLES = ("results.csv", "summary.csv", "report.html")
LIMIT = 120.0  # s


def call(name):
    """An entry of `controllers`."""
    return f'{{name: {name}, call: "drivers.py:{name}"}}'


def sweep(*arguments, jobs=1, code=0):
    """Runs a sweep in this process, with its results in `out`."""
    common = ("sweep", "scenarios.yaml", "--out", "out", "--jobs", str(jobs))
    assert main([*common, *arguments]) == code


def rows(folder="out"):
    with Path(folder, "results.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def journal(folder="out"):
    """The lines of results."""
    return Path(folder, "journal.jsonl").read_bytes().splitlines()[1:]


def start(*arguments):
    """Starts a sweep; returns when its first scenario is done."""
    process = subprocess.Popen(
        [sys.executable, "-m", "flatland2d", "sweep", "scenarios.yaml", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    lines = []
    for line in process.stderr:
        lines.append(line)
        if " scenarios, " in line:
            return process, lines
    pytest.fail("".join(lines) or "it has ended")


def children_of(process):
    """Its workers and their guards."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text()
    return [int(pid) for pid in children.split()]


def workers_of(process):
    return [pid for pid in children_of(process) if name_of(pid) != "sh"]


def name_of(pid):
    return Path(f"/proc/{pid}/comm").read_text().strip()


def staying():
    """The programs that controllers have started and left."""
    return [int(pid) for pid in Path("stay").read_text().split()]


def is_running(pid):
    """True if there is such a process, which is no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_100_scenarios_interrupted_continued_and_a_worker_killed(settings_of, capsys):
    settings_of(**QUICK, seeds=50, parameters="{controller.speed: [0.6, 1]}")
    assert main(["sweep", "scenarios.yaml", "--jobs", "1", "--out", "once", "--pictures", "2"]) == 0
    summary = capsys.readouterr().out

    process, _ = start("--jobs", "2", "--out", "out", "--pictures", "2")
    workers = workers_of(process)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=LIMIT)
    first = journal()
    assert process.returncode == 130
    assert f"interrupted: {len(first)} of 100 scenarios are done" in error
    assert "Traceback" not in error
    assert 1 <= len(first) < 100
    assert not Path("out/results.csv").exists()
    assert len(workers) == 2
    assert not any(map(is_running, workers))

    process, lines = start("--jobs", "2", "--out", "out", "--pictures", "2")
    for worker in workers_of(process):  # one may still be starting
        os.kill(worker, signal.SIGKILL)
    output, error = process.communicate(timeout=LIMIT)
    assert process.returncode == 0, error
    assert f"{len(first)} of 100 scenarios are done already\n" in lines
    assert re.search(r"scenario \d+ \(world .*\): its worker was killed by SIGKILL", error)
    assert journal()[: len(first)] == first
    assert len(journal()) == len({json.loads(line)["scenario"] for line in journal()}) == 100
    for name in TABLES:
        assert Path("out", name).read_bytes() == Path("once", name).read_bytes(), name
    assert output.replace("in out", "in once") == summary

    # Once more: nothing is left to do.
    before = journal()
    sweep("--pictures", "0")
    assert journal() == before


def test_workers_import_nothing_from_the_working_directory(folder, settings_of, monkeypatch):
    settings_of(**QUICK, seeds=1)
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "queue.py").write_text("raise SystemExit('planted')\n")
    monkeypatch.chdir(folder / "elsewhere")

    assert main(["sweep", "../scenarios.yaml", "--jobs", "1", "--pictures", "0"]) == 0


@pytest.mark.parametrize("is_written", [False, True])
def test_an_interruption_tells_of_what_is_in_the_journal(
    settings_of, capsys, monkeypatch, is_written
):
    write = Journal._write

    def interrupted(journal, line):
        is_third = len(journal.entries) == 2
        if is_written or not is_third:
            write(journal, line)
        if is_third:
            raise KeyboardInterrupt

    monkeypatch.setattr(Journal, "_write", interrupted)
    settings_of(**QUICK, seeds=5)

    sweep(code=130)

    assert f"interrupted: {2 + is_written} of 5 scenarios" in capsys.readouterr().err
    assert len(journal()) == 2 + is_written


def test_workers_that_do_not_start_are_an_error(settings_of, capsys, monkeypatch):
    settings_of()
    monkeypatch.setattr("flatland2d.sweep.local_pool._PROGRAM", "import no_such_module")

    assert main(["sweep", "scenarios.yaml", "--jobs", "2"]) == 1

    assert "flatland: worker processes do not start: " in capsys.readouterr().err


def test_scenarios_that_crash_hang_or_raise_have_a_reason(settings_of, capsys):
    entries = ", ".join(map(call, ("dies", "hangs", "fails", "towards")))
    once = '{name: once, call: "drivers.py:dies_once", arguments: {mark: mark}}'
    keys = {"controllers": f"[{entries}, {once}]", "seeds": "[2]"}
    settings_of(**QUICK, **keys, real_time_limit=6, retries=1)

    sweep(jobs=2, code=1)

    error = capsys.readouterr().err
    reasons = {row["controller"]: row["error"] for row in rows()}
    assert reasons == {
        "dies": "its worker was killed by SIGSEGV, at each attempt",
        "hangs": "it took more than 6 s of real time",
        "fails": "ZeroDivisionError: division by zero (drivers.py:45)",
        "towards": "",
        "once": "",
    }
    assert "controller once, seed 2): its worker was killed by SIGKILL; it is run again" in error
    assert (
        "3 of 5 scenarios failed to run to the end, most often by: its worker was killed by SIGSEGV"
    ) in error
    assert "--replay 1 shows it" in error
    with Path("out/timing.csv").open(newline="") as file:
        attempts = {row["scenario"]: row["attempts"] for row in csv.DictReader(file)}
    assert attempts == {"1": "2", "2": "1", "3": "1", "4": "1", "5": "2"}

    # Those that have failed can be run again, and nothing else is.
    settings_of(**QUICK, **keys, real_time_limit=1, retries=0)
    count = len(journal())
    sweep("--retry-failed", jobs=3, code=1)
    assert len(journal()) == count + 3


def test_a_sweep_can_be_extended(settings_of, capsys):
    settings_of(**QUICK, seeds=3)
    sweep()
    first = rows()

    settings_of(**QUICK, seeds=4)
    sweep()
    assert "3 of 4 scenarios are done already" in capsys.readouterr().err
    assert rows()[:3] == first

    settings_of(**QUICK, seeds=4, time_limit=1)
    sweep()
    error = capsys.readouterr().err
    assert "scenarios.yaml or a file that it names has changed: 4 results in out" in error
    assert "done already" not in error

    sweep("--restart")
    assert len(journal()) == 4


def test_the_report_stands_alone_and_shows_runs_without_success(settings_of, capsys):
    settings_of(**QUICK, seeds=3, controllers=f"[{call('ahead')}]")
    sweep()

    report = Path("out/report.html").read_text()
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', report)
    failed = [row["scenario"] for row in rows() if row["success"] == "false"]
    assert len(pictures) == len(failed) == report.count("<figure>") >= 1
    assert all(base64.b64decode(each).startswith(b"\x89PNG") for each in pictures)
    assert re.findall(r"--replay (\d+) --view", report) == failed
    assert "http" not in report
    output = capsys.readouterr()
    assert "success" in output.out
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        assert "no results.parquet: a Parquet file needs pyarrow" in output.err


def test_a_scenario_is_replayed_alone(settings_of, capsys, monkeypatch):
    settings_of(**QUICK, seeds=3)
    sweep()
    row = rows()[1]
    capsys.readouterr()

    sweep("--replay", "2")
    output = capsys.readouterr().out
    assert output.startswith("scenario 2 (world ")
    assert f"path_length: {row['path_length']}\n" in output
    assert output.endswith("the same as in out\n")

    pages = []
    monkeypatch.setattr(
        "flatland2d.picture_page.open_in_browser", lambda url: pages.append(Thread(url))
    )
    monkeypatch.setattr("flatland2d.cli.sweep_replay._RATE", 1000.0)
    sweep("--replay", "2", "--view")
    assert capsys.readouterr().out == output
    [thread] = pages
    thread.join()
    assert thread.count > 2


class Thread(threading.Thread):
    """A browser that shows a page of pictures until it ends; counts them."""

    def __init__(self, url):
        super().__init__()
        self.url = url
        self.start()

    def run(self):
        with urllib.request.urlopen(f"{self.url}pictures") as stream:
            self.count = stream.read().count(b"Content-Type: image/jpeg")


def test_a_replay_is_recorded(settings_of, capsys):
    rosbag = pytest.importorskip("rosbag")
    settings_of(**QUICK, seeds=2)

    assert main(["sweep", "scenarios.yaml", "--replay", "2", "--record", "run.bag"]) == 0

    assert capsys.readouterr().out.endswith("recorded in run.bag\n")
    with rosbag.Bag("run.bag") as bag:
        assert bag.get_message_count("/scan") > 10
    assert not Path("scenarios_results").exists()

    assert main(["sweep", "scenarios.yaml", "--replay", "2", "--record", "no/run.bag"]) == 1
    out, error = capsys.readouterr()
    assert out == ""
    assert error.startswith("flatland: no/run.bag: cannot be written")


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--view"], 2, "--view and --record are of --replay"),
        (["--jobs", "0"], 2, "expected a whole number of 1 or more"),
        (["--replay", "9"], 1, "expected a scenario of 1 to 4, found 9"),
        (["--out", "world.yaml"], 1, "world.yaml: cannot be made"),
    ],
)
def test_wrong_arguments(settings_of, capsys, arguments, code, message):
    settings_of()
    try:
        found = main(["sweep", "scenarios.yaml", *arguments])
    except SystemExit as error:
        found = error.code

    assert found == code
    assert message in capsys.readouterr().err


def test_without_ray_it_is_told_what_to_install(settings_of, capsys):
    if importlib.util.find_spec("ray") is not None:
        pytest.skip("Ray is installed")
    settings_of()

    assert main(["sweep", "scenarios.yaml", "--ray", "local"]) == 1

    said = capsys.readouterr().err
    assert "flatland: --ray needs Ray: pip install '.[ray]'" in said


def test_a_ray_worker_finds_the_files_in_its_working_directory(folder, settings_of):
    """On another machine, where the working directory is a copy of the folder."""
    settings = settings_of(seeds=1, controllers=f"[{call('ahead')}]")
    [scenario] = scenarios_of(settings)
    elsewhere = replace(settings, file=Path("/no/such/folder/scenarios.yaml"))
    try:
        done, messages = ray_pool._run_remotely(elsewhere, ScenarioRunner.run, scenario)
    finally:
        for pool in ray_pool._pools.values():
            pool.close()
        ray_pool._pools.clear()

    assert done.answer == ScenarioRunner(settings).run(scenario)
    assert (done.failure, messages) == ("", [])


@pytest.mark.parametrize("controller", ["hangs", "stops"])
def test_a_worker_ends_with_a_parent_that_was_killed(settings_of, controller):
    settings_of(controllers=f"[{call(controller)}, {{name: none}}]", seeds=1)
    process, _ = start("--jobs", "2", "--out", "out")
    children = children_of(process)
    if controller == "stops":
        children += wait_until(lambda: Path("stay").exists() and staying(), "it to stop")

    process.kill()
    process.communicate(timeout=LIMIT)

    wait_until(lambda: not any(map(is_running, children)), "the workers to end", LIMIT)


def test_a_forking_controller_answers_once_and_leaves_no_process(settings_of):
    names = ("towards", "forks", "forges")
    settings_of(**QUICK, controllers=", ".join(map(call, names)).join("[]"), seeds=8)

    sweep(jobs=2)

    found = {name: [row for row in rows() if row["controller"] == name] for name in names}
    for name in names:
        assert [row["note"] for row in found[name]] == [NOTES.get(name, "ok, so")] * 8
        for key in ("path_length", "scan", "draws"):
            assert [row[key] for row in found[name]] == [row[key] for row in found["towards"]]
    wait_until(lambda: not any(map(is_running, staying())), "the programs to end", LIMIT)


def test_answers_forged_by_other_processes_are_refused(settings_of, capsys):
    settings_of(**QUICK, controllers=f"[{call('forges')}]", seeds=1)

    sweep()

    error = capsys.readouterr().err
    assert re.search(r"to scenario 1, found one of process \d+ to scenario 9: it is refused", error)
    assert "found one of process 1 to scenario 1: it is refused" in error
    assert [row["note"] for row in rows()] == ["ok, so"]


def test_odd_texts_and_numbers_are_in_the_tables(settings_of, capsys):
    settings_of(**QUICK, controllers=f"[{call('odd')}]", seeds=5)

    for jobs in (2, 1):  # again, from the journal
        sweep(jobs=jobs, code=1)

    first, second, third, *_ = rows()
    assert (first["word"], first["text"], first["x"]) == ("a", r"\udfff", "1e+308")
    assert second["error"].startswith(r"ValueError: no text: \ud800 (drivers.py:")
    assert third["error"] == "expected numbers below 1.8e308, found a larger one: 'n'"
    assert r"no text: \ud800" in Path("out/report.html").read_text()
    sweep("--replay", "1")
    assert "the same as in out" in capsys.readouterr().out
