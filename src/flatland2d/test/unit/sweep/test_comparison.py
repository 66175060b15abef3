"""Paired comparisons: tests against exact probabilities, pairs against rows, and the gate."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from flatland2d.sweep.comparison import compare, comparison_rows, holm, junit, read_rows, verdicts
from flatland2d.sweep.metrics import SUMMARISED
from flatland2d.sweep.paper import figure, latex_table, markdown_table
from flatland_server.exceptions import FlatlandError

COLUMNS = ("success", "collision", "time_to_goal")


def runs(name, values):
    """Runs of a metric, by seeds."""
    return {("room", str(seed)): {name: value} for seed, value in enumerate(values)}


def rows(controller, times, world="room", **others):
    """Rows of results.csv: a time for each seed; None without success."""
    return [
        {
            "scenario": str(seed + 1),
            "world": world,
            "controller": controller,
            "seed": str(seed),
            "status": "done",
            "success": "false" if time is None else "true",
            "collision": "false",
            "time_to_goal": "" if time is None else repr(time),
            **others,
        }
        for seed, time in enumerate(times)
    ]


def test_mcnemars_test_is_binomial_in_the_pairs_that_differ():
    first = [True] * 6 + [False] + [True] * 10
    second = [False] * 6 + [True] + [True] * 10

    found = compare(runs("success", first), runs("success", second), "success")

    assert found.p == pytest.approx(2 * (1 + 7) / 2**7)  # 1 of 7 or fewer, on both sides
    assert (found.pairs, found.mean, found.other_mean) == (17, 16 / 17, 11 / 17)


def test_the_test_for_worse_is_one_sided_in_the_right_direction():
    fewer, more = runs("success", [False] * 5), runs("success", [True] * 5)

    assert compare(fewer, more, "success", worse=True).p == pytest.approx(0.5**5)
    assert compare(more, fewer, "success", worse=True).p == 1.0
    assert compare(more, fewer, "success").p == pytest.approx(2 * 0.5**5)
    hit, free = runs("collision", [True] * 5), runs("collision", [False] * 5)
    assert compare(hit, free, "collision", worse=True).p == pytest.approx(0.5**5)


def test_wilcoxons_test_is_exact_for_few_pairs():
    slow, fast = runs("time_to_goal", [1.1, 2.2, 3.3, 4.4]), runs("time_to_goal", [1, 2, 3, 4])

    assert compare(slow, fast, "time_to_goal", worse=True).p == pytest.approx(1 / 2**4)


def test_only_pairs_with_both_values_count():
    first = runs("time_to_goal", [1.0, None, 3.0, 4.0])
    second = runs("time_to_goal", [2.0, 2.0, None, 6.0])
    del second[("room", "3")]

    assert compare(first, second, "time_to_goal")[:3] == (1, 1.0, 2.0)
    found = compare(first, first, "time_to_goal")
    assert (found.low, found.high, found.p) == (0.0, 0.0, 1.0)


def test_runs_without_a_pair_are_not_compared():
    found = compare(runs("success", [True]), {}, "success")

    assert (found.pairs, found.p) == (0, 1.0)
    assert math.isnan(found.mean)


def test_the_bootstrap_interval_agrees_with_the_normal_one():
    rng = np.random.default_rng(1)
    base = rng.uniform(5, 9, 200)
    slower = runs("time_to_goal", (base + rng.normal(0.5, 0.2, 200)).tolist())

    found = compare(slower, runs("time_to_goal", base.tolist()), "time_to_goal")

    half = 1.96 * 0.2 / math.sqrt(200)
    assert found.high - found.low == pytest.approx(2 * half, rel=0.15)
    assert found.low < 0.5 < found.high


def test_holms_method():  # of 4: 4 x 0.005, 3 x 0.01, 2 x 0.03, and no less than the one before
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.9, 0.8]) == [1.0, 1.0]


def test_two_controllers_are_compared_in_each_world():
    table = [*rows("a", [1.0, 2.0]), *rows("b", [2.0, None])]
    table += [*rows("a", [1.0], world="hall"), *rows("b", [2.0], world="hall")]

    found = {(row["world"], row["metric"], row["pairs"]) for row in comparison_rows(table, {})}

    assert found >= {("room", "success", 2), ("room", "time_to_goal", 1), ("hall", "success", 1)}


def test_p_values_are_adjusted_for_the_metrics_that_were_chosen():
    seconds = [float(k) for k in range(1, 9)]
    table = [*rows("a", seconds), *rows("b", [2.0 * each for each in seconds])]

    def p_of(*metrics):
        found = {row["metric"]: row["p"] for row in comparison_rows(table, {}, metrics)}
        assert set(found) == set(metrics)
        return found["time_to_goal"]

    assert p_of("success", "time_to_goal") == pytest.approx(2.0 * p_of("time_to_goal"))


def test_worlds_of_a_group_are_compared_as_one():
    table = [row for world in "xyz" for name in "ab" for row in rows(name, [1.0], world=world)]

    found = comparison_rows(table, dict.fromkeys("xyz", "all"))

    assert {(row["world"], row["pairs"]) for row in found} == {("all", 3)}


def test_failed_runs_have_no_pair():
    table = [*rows("a", [1.0, 2.0]), *rows("b", [1.0, 2.0])]
    table[0]["status"] = "failed"

    assert {row["pairs"] for row in comparison_rows(table, {})} == {1}


def noisy(scale, seed, count=100):
    """Times of a controller: the same tasks, other chances."""
    tasks = np.random.default_rng(0).uniform(4, 12, count)
    return (scale * tasks * np.random.default_rng(seed).normal(1.0, 0.1, count)).tolist()


def test_the_gate_catches_ten_per_cent_and_nothing_else():
    base = rows("a", noisy(1.0, 0))

    def is_worse(scale, seed):
        found = verdicts(rows("a", noisy(scale, seed)), base, 0.01)
        return any(each.is_regression for each in found)

    assert all(is_worse(1.1, seed) for seed in range(1, 21))
    assert not any(is_worse(1.0, seed) for seed in range(1, 21))
    found = verdicts(rows("a", [None] * 10 + [5.0] * 90), rows("a", [5.0] * 100), 0.01)
    assert [each.metric for each in found if each.is_regression] == ["success"]


def test_a_change_within_the_tolerance_is_no_regression():
    before, now = rows("a", noisy(1.0, 0)), rows("a", [1.005 * t for t in noisy(1.0, 0)])

    assert not any(each.is_regression for each in verdicts(now, before, 0.01))
    assert any(each.is_regression for each in verdicts(now, before, 0.0))


def test_whole_numbers_and_fractions_of_a_parameter_are_paired():
    now = rows("a", [1.0], **{"controller.speed": "1"})
    before = rows("a", [1.0], **{"controller.speed": "1.0"})
    order = ("scenario", "world", "controller", "controller.speed", "seed", "status", *COLUMNS)
    now, before = ([{name: row[name] for name in order} for row in each] for each in (now, before))

    assert verdicts(now, before, 0.01)[0].result.pairs == 1


@pytest.mark.parametrize(
    ("before", "problem"),
    [
        (rows("b", [1.0]), "no scenario with the same world, controller"),
        (rows("a", [1.0] * 2), "for 3 of 5: 3, 4, 5; make a new baseline"),
        ([*rows("a", [1.0] * 5), rows("a", [1.0] * 2)[1]], "the baseline has scenario 2 twice"),
        (rows("a", [math.nan] * 5), "expected finite numbers in time_to_goal"),
        (rows("a", [math.inf] * 5), "expected finite numbers in time_to_goal"),
        (rows("a", ["soon"] * 5), "scenario 1: expected a number in time_to_goal"),
    ],
)
def test_a_baseline_that_is_not_of_these_scenarios_is_an_error(before, problem):
    with pytest.raises(FlatlandError, match=problem):
        verdicts(rows("a", [1.0] * 5), before, 0.01)


def test_a_failed_run_of_a_baseline_is_no_lack():
    before = rows("a", [1.0] * 5)
    before[2]["status"] = "failed"

    assert verdicts(rows("a", [1.0] * 5), before, 0.01)[0].result.pairs == 4


def test_a_baseline_of_other_parameters_is_an_error():
    def table(name):
        order = ("scenario", "world", "controller", name, "seed", "status", *COLUMNS)
        return [{each: row[each] for each in order} for row in rows("a", [1.0], **{name: "1"})]

    with pytest.raises(FlatlandError, match="by world, speed; found world, radius"):
        verdicts(table("speed"), table("radius"), 0.01)


def test_junit_has_a_case_for_each_comparison():
    without = rows("b", [None])
    found = verdicts(rows("a", [1.0] * 20) + without, rows("a", [0.5] * 20) + without, 0.01)

    suite = ElementTree.fromstring(junit("a sweep", found))

    assert suite.attrib == {"name": "a sweep", "tests": "6", "failures": "1", "skipped": "1"}
    [failure] = suite.iter("failure")
    assert "time to goal [s] 1, before 0.5 (20 pairs" in failure.get("message")


def test_names_with_control_characters_are_no_broken_xml():
    found = verdicts(rows("a\x00<", [1.0] * 20), rows("a\x00<", [0.5] * 20), 0.01)

    assert ElementTree.fromstring(junit("x", found)).find("testcase").get("classname") == (
        "room, a\N{REPLACEMENT CHARACTER}<"
    )


HEAD = b"scenario,world,controller,seed,status,success,collision,time_to_goal\n"


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "cannot be read"),
        (b"", "found no column scenario, world"),
        (b"a,b\n1,2\n", "found no column scenario, world"),
        (b"\xff\xfe", "expected results.csv of a sweep"),
        (b'a,"b\n', "expected results.csv of a sweep"),
        (HEAD + b"1,room,a,0,done,true,false\n", "expected as many values as columns in row 1"),
        (HEAD + b"1,room,a,0,done,true,false,1,2\n", "expected as many values as columns in row 1"),
    ],
)
def test_files_that_are_no_baseline(tmp_path, content, problem):
    if content is not None:
        (tmp_path / "results.csv").write_bytes(content)

    with pytest.raises(FlatlandError, match=problem):
        read_rows(tmp_path)


ENDS = ("", "_low", "_high")
ENDS_OF_TIME = tuple(f"time_to_goal{end}" for end in ENDS)
EMPTY = {f"{name}{end}": None for name in SUMMARISED for end in ENDS}
SUCCESS = {"success": 0.9, "success_low": 0.6, "success_high": 0.98}
SUMMARY = [
    {"world": "room_1", "controller": name, "scenarios": 10, "failed": 0, **EMPTY, **SUCCESS}
    for name in ("a & b", "c|d")
]


def test_a_table_for_latex_has_a_column_for_each_controller():
    notes, table = latex_table(SUMMARY).split("\\begin", 1)

    assert all(line.startswith("% ") for line in notes.splitlines())
    assert table == (
        "{tabular}{@{}lrr@{}}\n\\toprule\n & a \\& b & c|d \\\\\n\\midrule\n"
        "\\multicolumn{3}{@{}l@{}}{\\textit{room\\_1}} \\\\\n"
        "runs & 10 & 10 \\\\\n\\addlinespace[2pt]\n"
        "success~[\\%]~$\\uparrow$ & 90.0 & 90.0 \\\\\n"
        " & {\\scriptsize [60.0, 98.0]} & {\\scriptsize [60.0, 98.0]} \\\\\n"
        "\\bottomrule\n\\end{tabular}\n"
    )


def test_a_table_in_markdown():
    assert markdown_table(SUMMARY) == (
        "| world | metric | a & b | c\\|d |\n| --- | --- | --- | --- |\n"
        "| room_1 | runs | 10 | 10 |\n"
        "| room_1 | success [%] \N{UPWARDS ARROW} | 90.0 [60.0, 98.0] | 90.0 [60.0, 98.0] |\n"
    )


def test_numbers_of_a_metric_have_equally_many_decimals():
    def row(name, **values):
        ends = {
            f"{key}{end}": value for key, each in values.items() for end, value in zip(ENDS, each)
        }
        return {**SUMMARY[0], "controller": name, "failed": 1, **ends}

    none = (None, None, None)
    jerk, mine, far = (12.345, 9.0, 15.0), (2e-6, -3e-6, 7e-6), (3.0, None, None)
    first = row("a", mean_jerk=jerk, mine=mine, time_to_goal=far, spl=(0.0, -1e-9, 0.04))
    second = row(
        "b", mean_jerk=(0.5, 0.25, 0.75), mine=none, time_to_goal=none, spl=(0.5, 0.4, 0.6)
    )

    other = {**first, "world": "other", "controller": "c", "mean_jerk": 0.5, "stalled_time": 0.0}
    table = markdown_table([first, second, other])

    assert "| room_1 | failed to run | 1 | 1 |  |" in table
    assert (
        "| mean jerk [m/s³] \N{DOWNWARDS ARROW} | 12.3 [9.0, 15.0] | 0.5 [0.2, 0.8] |  |" in table
    )
    assert "| SPL \N{UPWARDS ARROW} | 0.000 [0.000, 0.040] | 0.500 [0.400, 0.600] |  |" in table
    assert "| mine | 2e-06 [-3e-06, 7e-06] |  |  |".replace("-", "\N{MINUS SIGN}") in table
    assert "| time to goal [s] \N{DOWNWARDS ARROW} | 3.00 |  |  |" in table
    assert "| other | SPL \N{UPWARDS ARROW} |  |  | 0.000 [0.000, 0.040] |" in table
    assert "| other | mean jerk [m/s³] \N{DOWNWARDS ARROW} |  |  | 0.5 [9.0, 15.0] |" in table
    assert "| other | stalled time [s] \N{DOWNWARDS ARROW} |  |  | 0.0 |" in table
    latex = latex_table([first, second])
    assert "mine & 2e$-$06 &  \\\\\n & {\\scriptsize [$-$3e$-$06, 7e$-$06]} &" in latex


def test_the_best_and_those_not_significantly_worse_are_bold():
    times = {
        "slow": [2.0 + 0.01 * k for k in range(8)],
        "even": [1.0] * 8,
        "best": [1.0 - (0.1 + 0.01 * k) * (-1) ** k for k in range(8)],
    }
    table = [row for name, each in times.items() for row in rows(name, each)]
    means = {"slow": 2.03, "even": 1.0, "best": 0.99}
    keys = {"world": "room", "scenarios": 8, "failed": 0}
    summary = [
        {**keys, "controller": k, **dict(zip(ENDS_OF_TIME, (mean, None, None)))}
        for k, mean in means.items()
    ]
    compared = comparison_rows(table, {}, ["time_to_goal"])

    latex = latex_table(summary, compared)

    # All 8 differences have a sign: 2 / 2^8, of 3 tests; the others rank sums of 16 and 20.
    assert "\ntime to & 2.03 & \\textbf{1.00} & \\textbf{0.99} \\\\\ngoal~[s]" in latex
    assert " & {\\scriptsize $p$ = 0.023} & {\\scriptsize $p$ = 0.844} &  \\\\" in latex
    assert "| 2.03, p = 0.023 | **1.00**, p = 0.844 | **0.99** |" in markdown_table(
        summary, compared
    )
    assert "textbf" not in latex_table(summary)


def test_a_figure_is_the_same_file_each_time():
    all_failed = [{**SUMMARY[0], "world": world, "success": None} for world in "ab"]
    for summary in (SUMMARY, all_failed):
        first = figure(summary)

        assert first.startswith(b"%PDF-")
        assert figure(summary) == first
