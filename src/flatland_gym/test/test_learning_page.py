"""docs/learning.md names all arguments and scenarios. Its examples are run in test/guide."""

import dataclasses
import re
from pathlib import Path

from flatland_gym import SCENARIOS, NavigationSettings

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "learning.md"


def test_all_arguments_and_scenarios_are_on_the_page():
    page = PAGE.read_text(encoding="utf-8")
    names = [field.name for field in dataclasses.fields(NavigationSettings)] + list(SCENARIOS)
    elsewhere = {"rewards", "params"}  # in an example; and as for a Simulation

    assert [n for n in names if n not in elsewhere and not re.search(rf"\b{n}\b", page)] == []
