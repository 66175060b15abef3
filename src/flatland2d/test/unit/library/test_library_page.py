"""docs/library.md has each public name. Its examples are run in test/guide."""

import re
from pathlib import Path

import pytest

from flatland2d import DriveHandle, ModelHandle, SensorHandle, Simulation, Touch

ROOT = Path(__file__).resolve().parents[5]
PAGE = ROOT / "docs" / "library.md"


@pytest.fixture(scope="module")
def page():
    return PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", [Simulation, ModelHandle, SensorHandle, DriveHandle, Touch])
def test_each_public_name_is_on_the_page(page, kind):
    names = {name for each in kind.__mro__[:-1] for name in vars(each) if not name.startswith("_")}
    inner = {"require_open", "plugin", "type"}

    missing = [name for name in sorted(names - inner) if not re.search(rf"\b{name}\b", page)]

    assert missing == []
