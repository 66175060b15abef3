"""The benchmark's command line: runs, reports and comparisons; speeds are not tested."""

import json
import re
import shlex
import sys
from pathlib import Path

import jsonschema
import pytest
from roslaunch.config import load_config_default

from flatland_benchmark import command
from flatland_benchmark.case import Case
from flatland_benchmark.cases import CASES
from flatland_benchmark.compare import changes, comparison
from flatland_benchmark.machine import Machine
from flatland_benchmark.report import CaseReport, Figure, Report

DOCS = Path(__file__).resolve().parents[4] / "docs"
PAGE = DOCS / "speed.md"
SRC = Path(__file__).resolve().parents[3]
LAUNCH_FILES = [
    SRC / "flatland_benchmark/launch/benchmark.launch",
    SRC / "flatland_server/launch/benchmark.launch",  # for users of the C++ Flatland
]
SCHEMA = SRC / "flatland_benchmark/benchmark.schema.json"
MACHINE = Machine("Linux", "a processor", 2, 0.5)


def report(machine=MACHINE, **cases):
    """A report of cases with one figure each, "step [us]", by their values."""
    reports = {
        name: CaseReport.of_runs("a case", [{"step [us]": value} for value in values])
        for name, values in cases.items()
    }
    return Report(machine, "0.1.0", "abc", "2020-01-01T00:00:00+00:00", reports)


def validate(path):
    """Validates a file against the schema; returns its content."""
    values = json.loads(path.read_text())
    jsonschema.validate(values, json.loads(SCHEMA.read_text()))
    return values


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The JSON report of a short case."""
    path = tmp_path_factory.mktemp("benchmark") / "room.json"
    assert command.main(["scan_room", "--runs", "2", "--json", str(path)]) == 0
    return path


def test_a_run_writes_what_the_schema_says(written):
    values = validate(written)

    assert list(values["cases"]) == ["scan_room"]
    beam = values["cases"]["scan_room"]["figures"]["beam"]
    assert beam["unit"] == "ns"
    assert len(beam["values"]) == 2
    assert beam["spread"] == [min(beam["values"]), max(beam["values"])]


def test_no_range_in_the_room_is_worse_than_box2ds(written):
    figures = Report.read(written).cases["scan_room"].figures

    assert figures["worse than Box2D's"].values == (0.0, 0.0)
    assert figures["rays cast"].median == 200 * 1081


def test_a_report_is_read_as_it_was_written(written, tmp_path):
    again = tmp_path / "again.json"
    again.write_text(Report.read(written).to_json())

    assert again.read_text() == written.read_text()


def test_figures_are_told_from_their_units():
    case = CaseReport.of_runs(
        "a case", [{"load [s]": 1.0, "times": 3}, {"load [s]": 2.0, "times": 5}]
    )

    assert case.figures == {"load": Figure("s", (1.0, 2.0)), "times": Figure("", (3, 5))}
    assert case.figures["load"].median == 1.5
    assert case.figures["load"].spread == (1.0, 2.0)


@pytest.mark.parametrize(
    ("before", "after", "ratio", "is_beyond"),
    [
        ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), 2.5, True),
        ((4.0, 5.0, 6.0), (1.0, 2.0, 3.0), 0.4, True),
        ((1.0, 2.0, 4.0), (4.0, 5.0, 6.0), 2.5, False),
        ((1.0, 2.0, 9.0), (4.0, 5.0, 6.0), 2.5, False),
        ((0.0,), (0.0,), 1.0, False),
        ((0.0,), (2.0,), float("inf"), True),
    ],
)
def test_a_change_is_beyond_the_spread_if_no_run_is_among_the_others(
    before, after, ratio, is_beyond
):
    [change] = changes(report(a=before), report(a=after))

    assert change.ratio == pytest.approx(ratio)
    assert change.is_beyond_spread == is_beyond


def test_a_comparison_names_what_only_one_has_and_other_machines():
    text = comparison(
        report(a=[1.0], b=[1.0]), report(MACHINE._replace(cores=4, load=9.0), b=[2.0], c=[1.0])
    )

    assert "only before: a" in text
    assert "only after: c" in text
    assert "machines differ" in text
    assert "machines differ" not in comparison(report(), report(MACHINE._replace(load=9.0)))


def test_the_command_compares_files(tmp_path, capsys):
    paths = [tmp_path / "a.json", tmp_path / "b.json"]
    for path, value in zip(paths, (2.0, 3.0)):
        path.write_text(report(scan=[value]).to_json())
        validate(path)

    assert command.main(["--compare", *map(str, paths)]) == 0

    [line] = [line for line in capsys.readouterr().out.splitlines() if line.startswith("scan")]
    assert line.split() == ["scan", "step", "[us]", "2", "3", "1.5", "yes"]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (None, "cannot be read: No such file"),
        ("x", "is not a report"),
        ("[]", "is not a report"),
        ('{"schema": 1}', "is not a report"),
        ('{"schema": 7}', "expected schema 1, found 7"),
    ],
)
def test_what_is_no_report_is_refused(tmp_path, capsys, text, complaint):
    path = tmp_path / "a.json"
    if text is not None:
        path.write_text(text)

    assert command.main(["--compare", str(path), str(path)]) == 2
    assert complaint in capsys.readouterr().err


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
    def measure(case, runs):
        if case.name == "parts_1":
            raise command.FlatlandError("the case parts_1 failed")
        return CaseReport.of_runs(case.description, [{"step [us]": 1.0}])

    monkeypatch.setattr(command, "measure", measure)
    path = tmp_path / "a.json"

    assert command.main(["parts_*", "--json", str(path)]) == 1
    assert "parts_1 failed" in capsys.readouterr().err
    assert "parts_1" not in validate(path)["cases"]
    assert "parts_100" in validate(path)["cases"]


def test_another_clone_runs_in_turn_in_its_own_workspace(tmp_path, monkeypatch, capsys):
    """A clone with a benchmark that measures 8 us."""
    package = tmp_path / "lib/flatland_benchmark"
    for folder in (package, tmp_path / "devel", tmp_path / "src/flatland_server/worlds"):
        folder.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "__main__.py").write_text(
        "import sys\nassert sys.argv[1:3] == ['--one', 'parts_1'], sys.argv\n"
        "print('{\"step [us]\": 8.0}')\n"
    )
    (tmp_path / "devel/setup.bash").write_text(f"export PYTHONPATH='{tmp_path / 'lib'}'\n")
    (tmp_path / "src/flatland_server/package.xml").write_text(
        "<package format='3'><name>flatland_server</name><version>0.0.7</version>"
        "<description>x</description><maintainer email='a@b.cd'>a</maintainer>"
        "<license>MIT</license></package>"
    )
    monkeypatch.setattr(command, "run_once", lambda case: {"step [us]": 2.0})

    assert command.main(["parts_1", "--base", str(tmp_path), "--runs", "2"]) == 0

    output = capsys.readouterr().out
    assert output.startswith("before: 0.0.7, commit unknown")
    [line] = [line for line in output.splitlines() if line.startswith("parts_1")]
    assert line.split() == ["parts_1", "step", "[us]", "8", "2", "0.25", "yes"]


def test_a_clone_that_is_not_built_is_refused(tmp_path, capsys):
    assert command.main(["parts_1", "--base", str(tmp_path)]) == 2
    assert "expected a clone that is built" in capsys.readouterr().err


@pytest.mark.slow
def test_a_case_that_fails_is_named(capfd):
    with pytest.raises(command.FlatlandError, match="no_such_case failed"):
        command.measure(Case("no_such_case", "", lambda _: {}), 1)

    assert "KeyError: 'no_such_case'" in capfd.readouterr().err


def test_every_case_has_a_name_for_the_table_and_a_sentence():
    for name, case in CASES.items():
        assert name == case.name
        assert len(name) <= 26
        assert case.description
        assert not case.description.endswith(".")


def test_pictures_need_matplotlib(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)

    assert command.main(["scan_room", "--plots", str(tmp_path)]) == 2
    assert "apt-get install python3-matplotlib" in capsys.readouterr().err


def test_pictures_of_a_report(written, tmp_path):
    pytest.importorskip("matplotlib")

    assert command.main(["--from", str(written), "--plots", str(tmp_path)]) == 0

    [picture] = tmp_path.iterdir()
    assert picture.name == "speed_rays.png"
    assert picture.stat().st_size > 1000


def test_the_page_has_all_cases_and_no_others():
    text = PAGE.read_text() + (DOCS / "speed_of_programs.md").read_text()
    cells = re.findall(r"^\| (`.*?) \|", text, flags=re.MULTILINE)
    single = "history|spawn|plugins|start"
    names = [name for cell in cells for name in re.findall(rf"`(\w+_\w+|{single})`", cell)]

    assert sorted(names) == sorted(CASES)


def test_the_commands_of_the_page_are_understood():
    lines = re.findall(r"^scripts/bench(.*)$", PAGE.read_text(), flags=re.MULTILINE)

    assert len(lines) > 3
    for line in lines:
        options = command.parser().parse_args(shlex.split(line, comments=True))
        assert command.select(options.cases)


def test_the_file_of_the_page_is_a_report(tmp_path):
    [block] = re.findall(r"```json\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)
    path = tmp_path / "page.json"
    path.write_text(block)

    validate(path)
    assert json.loads(Report.read(path).to_json()) == json.loads(block)


def test_the_pictures_of_the_page_are_there():
    for image in re.findall(r"!\[.*?\]\((.*?)\)", PAGE.read_text()):
        assert (PAGE.parent / image).is_file()


def launched(launch, *arguments):
    """The configuration that roslaunch makes of a launch file with these arguments."""
    return load_config_default([(str(launch), list(arguments))], None, verbose=False)


def options_of(launch, *arguments):
    """The command's options when a launch file has these arguments."""
    [node] = launched(launch, *arguments).nodes
    return command.parser().parse_args(shlex.split(node.args))


@pytest.mark.slow
@pytest.mark.parametrize("launch", LAUNCH_FILES, ids=lambda path: path.parts[-3])
def test_the_launch_file_hands_its_arguments_on(launch):
    options = options_of(launch, "cases:=scan_* spawn", "runs:=2", "json:=/my figures/now.json")

    assert options.cases == ["scan_*", "spawn"]
    assert options.runs == 2
    assert options.json == Path("/my figures/now.json")
    assert options.plots is None
    assert not options.world
    assert options.launch_files == LAUNCH_FILES
    assert options_of(launch, "world_path:=/a.yaml").world


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
    assert benchmark.launch_prefix == "perf record -g"
    assert window.type == "flatland_viz"
    assert config.params["/flatland_benchmark/simplify_map"].value == 2
    assert config.params["/flatland_benchmark/benchmark_duration"].value == 5


@pytest.mark.parametrize("arguments", [["spawn"], ["--plots", "/tmp"]])
def test_a_world_is_run_instead_of_cases(capsys, arguments):
    assert command.main([*arguments, "--world"]) == 2

    given = "plots" if "--plots" in arguments else "cases"
    assert f"expected world_path or {given}, found both" in capsys.readouterr().err
