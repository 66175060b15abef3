"""The benchmark's command line: runs and comparisons; speeds are not tested."""

import json
import re
import shlex
from pathlib import Path

import pytest
from roslaunch.config import load_config_default

from flatland_benchmark import command
from flatland_benchmark.case import Case, case
from flatland_benchmark.cases import CASES
from flatland_benchmark.runs import Clone, is_beyond_spread, ratio
from flatland_benchmark.tables import head, row

DOCS = Path(__file__).resolve().parents[4] / "docs"
PAGE = DOCS / "speed.md"
SRC = Path(__file__).resolve().parents[3]
LAUNCH_FILES = [
    SRC / "flatland_benchmark/launch/benchmark.launch",
    SRC / "flatland_server/launch/benchmark.launch",  # for users of the C++ Flatland
]


def cells(line):
    """The cells of a row of a table."""
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_a_run_is_printed_and_written(tmp_path, capsys):
    path = tmp_path / "room.json"

    assert command.main(["scan_room", "--runs", "2", "--json", str(path)]) == 0

    runs = json.loads(path.read_text())["scan_room"]
    assert len(runs) == 2
    assert runs[0]["rays cast"] == 200 * 1081
    assert runs[0]["differing rays"] <= 20
    beams = sorted(run["beam [ns]"] for run in runs)
    [line] = [line for line in capsys.readouterr().out.splitlines() if "| beam [ns]" in line]
    assert [float(cell) for cell in cells(line)[3:]] == pytest.approx(beams, rel=1e-3)


def test_a_table_is_markdown():
    text = f"{head('case', 'median')}\n{row('a', 216200.4)}\n{row('b', 0.123456)}"

    assert [cells(line) for line in text.splitlines()] == [
        ["case", "median"],
        ["---", "---:"],
        ["a", "216,200"],
        ["b", "0.1235"],
    ]


def test_a_function_with_values_is_a_case_for_each_combination(monkeypatch):
    monkeypatch.setattr("flatland_benchmark.case.CASES", found := {})

    @case("a_{robots}_{beams}", "with {robots}", robots=(1, 2), beams=(64,))
    def measure(worlds, robots, beams):
        return {"sum": robots + beams}

    assert list(found) == ["a_1_64", "a_2_64"]
    assert found["a_2_64"].description == "with 2"
    assert found["a_2_64"].run(Path()) == {"sum": 66}


@pytest.mark.parametrize(
    ("before", "after", "change", "is_beyond"),
    [
        ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 2.5, True),
        ([4.0, 5.0, 6.0], [1.0, 2.0, 3.0], 0.4, True),
        ([1.0, 2.0, 4.0], [4.0, 5.0, 6.0], 2.5, False),
        ([1.0, 2.0, 9.0], [4.0, 5.0, 6.0], 2.5, False),
        ([0.0], [0.0], 1.0, False),
        ([0.0], [2.0], float("inf"), True),
    ],
)
def test_a_change_counts_if_the_runs_do_not_overlap(before, after, change, is_beyond):
    assert ratio(before, after) == pytest.approx(change)
    assert is_beyond_spread(before, after) == is_beyond


def test_an_unknown_case_is_refused_before_anything_runs(capsys):
    assert command.main(["scan_room", "scan_ofice"]) == 2

    output = capsys.readouterr()
    assert output.err == (
        'flatland_benchmark: unknown case "scan_ofice" (did you mean "scan_office"?); '
        "--list shows all\n"
    )
    assert output.out == ""


def test_cases_are_chosen_by_pattern_and_run_once():
    names = [case.name for case in command.select(["scan_b*", "scan_*", "scan_bodies"])]

    assert names[0] == "scan_bodies"
    assert sorted(names) == sorted(name for name in CASES if name.startswith("scan_"))


@pytest.mark.parametrize("runs", ["0", "-1", "some"])
def test_a_number_of_runs_below_one_is_refused(capsys, runs):
    with pytest.raises(SystemExit) as caught:
        command.main(["--runs", runs])

    assert caught.value.code == 2
    assert "--runs" in capsys.readouterr().err


def test_the_others_run_when_a_case_fails(monkeypatch, capsys, tmp_path):
    def run(clone, case):
        if case.name == "serve_1":
            raise command.FlatlandError("the case serve_1 failed")
        return {"step [us]": 1.0}

    monkeypatch.setattr(Clone, "run", run)
    path = tmp_path / "a.json"

    assert command.main(["serve_1", "serve_10", "--json", str(path), "--runs", "1"]) == 1
    assert "serve_1 failed" in capsys.readouterr().err
    assert json.loads(path.read_text()) == {"serve_10": [{"step [us]": 1.0}]}


def test_another_clone_runs_in_turn_in_its_own_workspace(tmp_path, monkeypatch, capsys):
    """A clone with a benchmark that measures 8 us, and nothing of ours else."""
    package = tmp_path / "lib/flatland_benchmark"
    for folder in (package, tmp_path / "devel", tmp_path / "src/flatland_server/worlds"):
        folder.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "__main__.py").write_text(
        "import sys\nassert sys.argv[1:3] == ['--one', 'serve_1'], sys.argv\n"
        "print('{\"step [us]\": 8.0}')\n"
    )
    (tmp_path / "devel/setup.bash").write_text(f"export PYTHONPATH='{tmp_path / 'lib'}'\n")
    theirs = Clone.run
    monkeypatch.setattr(
        Clone,
        "run",
        lambda clone, case: (
            theirs(clone, case) if clone._shell else {"step [us]": 2.0, "memory [MB]": 1.0}
        ),
    )

    assert command.main(["serve_1", "--base", str(tmp_path), "--runs", "2"]) == 0

    [line] = [line for line in capsys.readouterr().out.splitlines() if "serve_1" in line]
    assert cells(line) == ["serve_1", "step [us]", "8", "2", "0.25", "yes"]


def test_a_clone_that_is_not_built_is_refused(tmp_path, capsys):
    assert command.main(["serve_1", "--base", str(tmp_path)]) == 2
    assert "expected a clone that is built" in capsys.readouterr().err


@pytest.mark.slow
def test_a_case_that_fails_is_named(capfd):
    with pytest.raises(command.FlatlandError, match="no_such_case failed"):
        Clone().run(Case("no_such_case", "", lambda _: {}))

    assert "KeyError: 'no_such_case'" in capfd.readouterr().err


def test_every_case_has_a_name_for_the_table_and_a_sentence():
    for name, each in CASES.items():
        assert name == each.name
        assert len(name) <= 26
        assert each.description
        assert not each.description.endswith(".")


def test_the_pages_have_all_cases_and_no_others():
    text = PAGE.read_text() + (DOCS / "speed_of_programs.md").read_text()
    rows = re.findall(r"^\| (`.*?) \|", text, flags=re.MULTILINE)
    single = "gate|history|plugins|start"
    names = [name for each in rows for name in re.findall(rf"`(\w+_\w+|{single})`", each)]

    assert sorted(names) == sorted(CASES)


def test_the_commands_of_the_page_are_understood():
    text = PAGE.read_text()
    lines = re.findall(r"^(?:\| `)?scripts/bench(.*?)(?:` \|.*)?$", text, flags=re.MULTILINE)

    assert len(lines) > 6
    for line in lines:
        options = command.parser().parse_args(shlex.split(line, comments=True))
        assert command.select(options.cases)


def launched(launch, *arguments):
    """The configuration that roslaunch makes of a launch file with these arguments."""
    return load_config_default([(str(launch), list(arguments))], None, verbose=False)


@pytest.mark.slow
@pytest.mark.parametrize("launch", LAUNCH_FILES, ids=lambda path: path.parts[-3])
def test_arguments_of_the_cpp_flatlands_benchmark_are_taken(launch):
    config = launched(
        launch,
        "world_path:=/a.yaml",
        *("benchmark_duration:=5", "update_rate:=100", "step_size:=0.01", "viz_pub_rate:=5"),
        *("show_viz:=true", "use_rviz:=false", "simplify_map:=2", "use_perf:=true"),
    )

    benchmark, window = config.nodes
    options = command.parser().parse_args(shlex.split(benchmark.args))
    assert options.world
    assert options.launch_files == LAUNCH_FILES
    assert benchmark.launch_prefix == "perf record -g"
    assert window.type == "flatland_viz"
    assert config.params["/flatland_benchmark/simplify_map"].value == 2
    assert config.params["/flatland_benchmark/benchmark_duration"].value == 5
