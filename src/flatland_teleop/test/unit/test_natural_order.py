"""Names in the order in which people list them."""

import pytest

from flatland_teleop.natural_order import natural_key


@pytest.mark.parametrize(
    "ordered",
    [
        ["r2", "r10"],
        ["r2/scan", "r10/scan"],
        ["1", "2", "10", "a"],
        ["box", "box_1", "box_2", "box_11", "boxes"],
        ["a1b2", "a1b10", "a2b1"],
    ],
)
def test_natural_order(ordered):
    names = ordered[::-1]

    assert sorted(names, key=natural_key) == ordered
