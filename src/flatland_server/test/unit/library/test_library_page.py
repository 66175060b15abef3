"""docs/library.md: its examples run as one program, and each public name is in one of them."""

import importlib.util
import re
import runpy
from pathlib import Path

import pytest

from flatland_server import ModelHandle, Sensor, Simulation, Touch

ROOT = Path(__file__).resolve().parents[5]
PAGE = ROOT / "docs" / "library.md"
program_of = runpy.run_path(str(ROOT / "scripts" / "doc_program.py"))["program_of"]


@pytest.fixture(scope="module")
def page():
    return PAGE.read_text(encoding="utf-8")


def test_the_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    has_rosbags = importlib.util.find_spec("rosbags") is not None

    program = program_of(page, without=() if has_rosbags else ("record",))

    exec(compile(program, str(PAGE), "exec"), {"__name__": "__main__"})
    assert (tmp_path / "world.svg").exists()


def test_the_program_has_all_blocks_at_the_lines_of_the_page(page):
    lines, program = page.splitlines(), program_of(page).splitlines()

    assert sum(line != "" for line in program) > 100
    assert [line for line in program if line] == [
        lines[number] for number, line in enumerate(program) if line
    ]
    assert len(re.findall("```python", page)) == len(re.findall(r"```python\n(?!```)", page))


@pytest.mark.parametrize("kind", [Simulation, ModelHandle, Sensor, Touch])
def test_each_public_name_is_on_the_page(page, kind):
    names = {name for each in kind.__mro__[:-1] for name in vars(each) if not name.startswith("_")}
    inner = {"require_open", "plugin", "type"}

    missing = [name for name in sorted(names - inner) if not re.search(rf"\b{name}\b", page)]

    assert missing == []
