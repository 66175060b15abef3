"""The rooms of the core use each other as their READMEs say."""

import re
from pathlib import Path

import pytest

CORE = Path(__file__).parents[2] / "src" / "core"
ROOMS = sorted(path.parent.name for path in CORE.glob("*/README.md"))


def allowed(room):
    """The room, and those that its README names as used."""
    [uses] = re.findall(r"^Uses: ([^.]*)", (CORE / room / "README.md").read_text(), re.MULTILINE)
    return {room, *re.findall(r"`(\w+)`", uses)}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_includes_only_rooms_named_in_its_readme(room):
    for path in sorted((CORE / room).glob("*.[ch]pp")):
        included = set(re.findall(r'#include "(\w+)/', path.read_text()))
        assert included <= allowed(room), path.name


def test_only_the_bindings_know_python():
    for room in set(ROOMS) - {"bindings"}:
        for path in (CORE / room).glob("*.[ch]pp"):
            assert not re.search(r"pybind11|Python\.h", path.read_text()), path.name
