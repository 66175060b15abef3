"""The keys that drive are the same everywhere, and in the documentation."""

from pathlib import Path

from flatland_teleop.driving_keys import DIRECTIONS, HELP, Direction, direction
from flatland_teleop.teleop_keyboard_node import help_lines

DOCS = Path(__file__).resolve().parents[4] / "docs"


def test_keys_add_up_and_opposite_ones_cancel_each_other():
    assert direction([]) == Direction()
    assert direction(["up", "left", "w"]) == Direction(forwards=1.0, turn=1.0)
    assert direction(["w", "s", "e"]) == Direction(left=-1.0)


def test_the_help_names_all_keys():
    named = " ".join(keys for keys, _ in HELP).lower()
    letters = {key for key in DIRECTIONS if len(key) == 1}
    assert {letter for letter in letters if letter in named.replace(",", " ").split()} == letters


def test_the_table_of_the_documentation_has_them():
    text = (DOCS / "window.md").read_text()
    for keys, what in HELP:
        assert f"| {keys} | {what} |" in text


def test_the_tutorial_shows_what_the_terminal_shows():
    assert "\n".join(help_lines()) in (DOCS / "tutorials" / "driving.md").read_text()
