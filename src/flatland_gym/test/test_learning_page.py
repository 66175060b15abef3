"""docs/learning.md: its examples run as one program, and it names all arguments and scenarios."""

import dataclasses
import importlib.util
import re
import runpy
from pathlib import Path

import pytest

from flatland_gym import SCENARIOS, NavigationSettings

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "learning.md"
program_of = runpy.run_path(str(ROOT / "scripts" / "doc_program.py"))["program_of"]


@pytest.mark.slow
def test_the_examples_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    needs = ("pettingzoo", "stable_baselines3")
    missing = [name for name in needs if importlib.util.find_spec(name) is None]

    program = program_of(PAGE.read_text(encoding="utf-8"), without=missing)

    exec(compile(program, str(PAGE), "exec"), {"__name__": "__main__"})
    assert (tmp_path / "policy.npz").exists()


def test_all_arguments_and_scenarios_are_on_the_page():
    page = PAGE.read_text(encoding="utf-8")
    names = [field.name for field in dataclasses.fields(NavigationSettings)] + list(SCENARIOS)
    elsewhere = {"rewards", "params"}  # in an example; and as for a Simulation

    assert [n for n in names if n not in elsewhere and not re.search(rf"\b{n}\b", page)] == []
