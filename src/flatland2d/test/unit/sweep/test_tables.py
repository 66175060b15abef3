"""Intervals, tables and journals: numbers against formulas, files against their content."""

import csv
import io
import json
import math
from contextlib import closing

import pytest

from flatland2d.sweep.intervals import mean, rate, t_quantile
from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.paper import figure, latex_table, markdown_table, with_metrics
from flatland2d.sweep.report import summary_cells, text_table
from flatland2d.sweep.runner import Result
from flatland2d.sweep.settings import scenarios_of
from flatland2d.sweep.sweep import Journal, read_entries
from flatland2d.sweep.tables import column, csv_bytes, summary_rows, table_of
from flatland_server.exceptions import FlatlandError


@pytest.mark.parametrize(
    ("freedom", "t"),  # of published tables; at last that of the normal distribution
    [(1, 12.7062), (2, 4.30265), (5, 2.57058), (30, 2.04227), (200, 1.97190), (10**9, 1.959964)],
)
def test_the_quantile_of_students_t(freedom, t):
    assert t_quantile(freedom) == pytest.approx(t, abs=1e-5)
    assert 0.0 < t_quantile(200) - t_quantile(201) < 1e-4


def test_wilsons_interval():
    found = rate(8, 10)  # from the formula by hand: (0.8 + 0.19207 +- 0.31344) / 1.38415

    assert found == pytest.approx((0.8, 0.490162, 0.943318), abs=1e-6)
    assert rate(0, 10)[:2] == (0.0, 0.0)
    assert rate(10, 10)[::2] == (1.0, 1.0)
    assert all(map(math.isnan, rate(0, 0)))


def test_the_interval_of_a_mean():
    half = 4.302653 / math.sqrt(3)  # s = 1

    assert mean([1.0, 2.0, 3.0]) == pytest.approx((2.0, 2.0 - half, 2.0 + half), abs=1e-6)
    assert mean([2.0])[0] == 2.0
    assert math.isnan(mean([2.0]).low)
    assert mean([2.0, math.inf]).value == math.inf


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([True, None], "bool"),
        ([1, 2], "int64"),
        ([1, 2.5], "float64"),
        ([None, None], "float64"),
        (["a", 1], "string"),
        ([[1, 2], [3, 4]], "string"),
        ([True, 1], "string"),
        ([1 << 70], "string"),
    ],
)
def test_a_column_has_the_type_that_fits(values, kind):
    assert column("name", values).type == kind


def test_csv_can_be_read_back():
    rows = [{"a": 0.1 + 0.2, "b": True, "c": None, "d": 'x, "y"'}, {"a": math.inf, "b": False}]

    content = csv_bytes(table_of(rows)).decode()

    first, second = csv.DictReader(io.StringIO(content, newline=""))
    assert float(first["a"]) == 0.1 + 0.2
    assert float(second["a"]) == math.inf
    assert (first["b"], first["c"], first["d"]) == ("true", "", 'x, "y"')


def test_intervals_end_where_the_range_of_a_metric_does(settings_of):
    [scenario, *_] = scenarios_of(settings_of())
    rows = [{"spl": 0.0, "min_clearance": 0.01}, {"spl": 1.0, "min_clearance": 0.5}]
    results = [
        (scenario, Result({**row, "jerk": 0.0}, {"n": 9.0 * k}, seconds=1.0, attempts=1))
        for k, row in enumerate(rows)
    ]

    [row] = summary_rows(results)

    assert (row["spl_low"], row["spl_high"], row["spl_count"]) == (0.0, 1.0, 2)
    assert row["min_clearance_low"] == 0.0
    assert row["min_clearance_high"] > 3.0
    assert row["n_low"] < -50.0  # a controller's number may be negative


def test_a_table_for_a_paper_has_the_metrics_that_were_chosen(settings_of):
    [scenario, *_] = scenarios_of(settings_of())
    entry = Result({"spl": 0.5, "success": True}, {"n": 1}, seconds=1.0, attempts=1)

    table = markdown_table(with_metrics(summary_rows([(scenario, entry)]), ["spl"]))

    assert [line.split(" | ")[1] for line in table.splitlines()[2:]] == ["runs", "SPL ↑", "n"]


def test_names_with_any_characters_are_cells_of_one_line(settings_of):
    name = "a|b\n\n_c & 5 %\r<b>\x1b[31m"
    controllers = f"[{{name: {json.dumps(name)}, call: 'drivers.py:ahead'}}]"
    [scenario, *_] = scenarios_of(settings_of(controllers=controllers))
    summary = summary_rows([(scenario, Result({"success": True}, {}, seconds=1.0, attempts=1))])

    [head, *_] = markdown_table(summary).splitlines()
    assert head == "| world | metric | a\\|b  _c & 5 % \\<b> [31m |"
    assert " & a|b  \\_c \\& 5 \\% $<$b> [31m \\\\" in latex_table(summary).splitlines()
    assert len(text_table(*summary_cells(summary, is_brief=True)).splitlines()) == 2


def test_a_metric_that_is_always_zero_has_no_panel():
    pytest.importorskip("matplotlib")
    row = {name: None for each in SUMMARISED for name in (each, f"{each}_low", f"{each}_high")}
    row = {"world": "a", "controller": "b", "scenarios": 2, "failed": 0, **row, "spl": 0.5}

    with_zero = figure([{**row, "stalled_time": 0.0, "intimate_fraction": 0.0}])

    assert with_zero == figure([row])
    assert with_zero != figure([{**row, "stalled_time": 1.0}])


ENTRY = Result({"time": 0.1 + 0.2, "goal_x": math.nan}, {"n": 1}, seconds=1.5, attempts=1)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "journal.jsonl"


def test_a_journal_goes_on_where_it_has_ended(path):
    with closing(Journal(path)) as journal:
        journal.add("a", ENTRY)
    complete = path.read_bytes()
    path.write_bytes(complete + complete.splitlines()[1][:30])  # a crash while it was written

    with closing(Journal(path)) as journal:
        assert list(journal.entries) == ["a"]
        assert repr(journal.entries["a"]) == repr(ENTRY)
        journal.add("b", ENTRY)

    assert list(read_entries(path)) == ["a", "b"]


@pytest.mark.parametrize(
    ("line", "old", "new"),
    [
        (1, b"format", b"fomat"),
        (3, b'"n": 1', b'"n": 2'),
        (3, b'"n"', b"\xff\x00"),
        (3, b"{", b"[" * 100_000),
        (3, b", ", b"\n"),
    ],
)
def test_damaged_lines_of_a_journal_are_left_out(path, line, old, new):
    with closing(Journal(path)) as journal:
        for name in "abc":
            journal.add(name, ENTRY)
    lines = path.read_bytes().splitlines(keepends=True)
    lines[line - 1] = lines[line - 1].replace(old, new, 1)
    path.write_bytes(b"".join(lines))

    with closing(Journal(path)) as journal:
        assert journal.damaged[0] == line
        assert set(journal.entries) == set("abc" if line == 1 else "ac")
        journal.add("b", ENTRY)

    found = read_entries(path)
    assert {name: repr(entry) for name, entry in found.items()} == dict.fromkeys("abc", repr(ENTRY))


def test_a_journal_is_written_by_one_sweep_at_a_time(path):
    with closing(Journal(path)), pytest.raises(FlatlandError, match="another sweep"):
        Journal(path)


@pytest.mark.parametrize("content", ["a,b\n1,2\n", '{"format": "other"}\n', "[]\n", "a line"])
def test_another_file_is_no_journal_and_stays_as_it_is(path, content):
    path.write_text(content)

    with pytest.raises(FlatlandError, match="no journal"):
        Journal(path)

    assert path.read_text() == content
