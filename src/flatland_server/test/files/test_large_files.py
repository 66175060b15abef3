"""Files of thousands of entries: they load, or are refused, in time proportional to that.

The limit of processor time is several times what is needed, and less than what a quadratic step
takes.
"""

import time

import pytest

from flatland_server.exceptions import MAX_SHOWN, Problem, YamlError, listed, suggestion

COUNT = 8_000
CIRCLE = "{type: circle, radius: 0.1, density: 1}"
FOOTPRINTS = "bodies:\n- name: base\n  footprints:\n"
BODIES = "bodies:\n" + "".join(
    f"- {{name: b{i}, footprints: [{CIRCLE}]}}\n" for i in range(COUNT // 10)
)

LARGE = {
    "footprints": (FOOTPRINTS + f"    - {CIRCLE}\n" * COUNT, 0),
    "uses of a wrong alias": (
        FOOTPRINTS + "    - &a {type: circle, radius: -1, density: 1}\n" + "    - *a\n" * COUNT,
        COUNT + 1,
    ),
    "misspelt keys": (
        FOOTPRINTS + "    - {type: circle, radus: 1, density: 1}\n" * COUNT,
        2 * COUNT,
    ),
    "unknown keys": (
        FOOTPRINTS + f"    - {CIRCLE}\n" + "".join(f"key{i}: 1\n" for i in range(COUNT)),
        COUNT,
    ),
    "joints of unknown bodies": (
        f"{BODIES}joints:\n"
        + "".join(
            f"- {{type: weld, name: j{i}, bodies: "
            f"[{{name: c{i}, anchor: [0, 0]}}, {{name: b{i}, anchor: [0, 0]}}]}}\n"
            for i in range(COUNT // 10)
        ),
        COUNT // 10,
    ),
    "plugins of unknown bodies": (
        f"{BODIES}plugins:\n"
        + "".join(f"- {{type: Gps, name: g{i}, body: c{i}}}\n" for i in range(COUNT // 10)),
        COUNT // 10,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(("model", "problems"), LARGE.values(), ids=LARGE.keys())
def test_a_large_wrong_file_is_read_fast_and_problems_counted(files, model, problems):
    begin = time.process_time()
    try:
        files.spawn(model)
        message = ""
    except YamlError as error:
        message = str(error)

    assert time.process_time() - begin < 6.0
    lines = message.splitlines()
    if problems:
        assert len(lines) == MAX_SHOWN + 1
        assert lines[-1] == f"and {problems - MAX_SHOWN} more problems"
        assert len(message) < 30_000
    else:
        assert not lines


def test_a_single_problem_more_is_counted_in_the_singular(tmp_path):
    error = YamlError.of(Problem(tmp_path, f"wrong {i}") for i in range(MAX_SHOWN + 1))

    assert str(error).splitlines()[-1] == "and 1 more problem"


def test_a_list_of_names_ends_with_the_number_of_the_others():
    assert listed([]) == "none"
    assert listed(["a", "b"]) == "a, b"
    assert listed([f"n{i}" for i in range(100)]).endswith("n29 and 70 more")


def test_no_key_is_suggested_for_a_very_long_word():
    assert suggestion("range" * 10_000, ["range"]) == ""


@pytest.mark.parametrize(
    "lists",
    [
        "- &b {name: b, footprints: [&c {type: circle, radius: 1, density: 1}, USES]}\nBASES",
        "- {name: b, footprints: [&c {type: circle, radius: 1, density: 1, layers: [ALL]}, USES]}",
    ],
    ids=["a million footprints", "a million names of layers"],
)
def test_a_million_values_by_aliases_are_refused_early(files, lists):
    uses, names, bases = ("*c, " * 1000)[:-2], ("all, " * 1000)[:-2], "- *b\n" * 1000
    text = lists.replace("USES", uses).replace("ALL", names).replace("BASES", bases)
    begin = time.process_time()

    with pytest.raises(YamlError) as caught:
        files.spawn(f"bodies:\n{text}\n")

    assert "expected at most 1000000 keys and values, each use of an alias" in str(caught.value)
    assert time.process_time() - begin < 2.0


def test_aliases_of_aliases_are_not_nested_deeper_than_lists(files):
    nested = "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 3000))

    with pytest.raises(YamlError, match="expected at most 100 levels"):
        files.spawn(f"a0: &a0 [1]\n{nested}bodies: []\n")
