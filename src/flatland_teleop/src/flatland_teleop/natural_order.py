"""Names in the order in which people list them."""

import re
from typing import Any, Tuple


def natural_key(name: str) -> Tuple[Any, ...]:
    """A key to sort by in natural order: r2 before r10."""
    return tuple(
        (0, int(part), "") if part.isdecimal() else (1, 0, part)
        for part in re.split(r"([0-9]+)", name)
        if part
    )
