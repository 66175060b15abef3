"""The keys and what they do, as the help shows them."""

from typing import List

from flatland_teleop.driving_keys import HELP

KEYS = (
    *HELP,
    ("Tab, click", "follow a robot: the next one, or a model that is clicked"),
    ("F", "follow, or stop following"),
    ("drag, wheel", "move and zoom the picture; Home: show all"),
    ("space", "pause, go on"),
    (". ,", "a single step on (also F10), or back"),
    ("PgUp PgDn", "10 s back, or on; with Shift 1 s; End: the latest moment"),
    ("timeline", "go to a moment; the run goes on from there"),
    ("+ -", "faster, slower"),
    ("R", "reset the world"),
    ("L", "lidars and other sensors"),
    ("N T", "names of models; the trail of the robot"),
    ("P", "save a picture"),
    ("H, F1", "this help"),
    ("Esc", "leave this help; stop following"),
    ("Ctrl+Q", "quit"),
)
"""Keys, and what they do."""


def help_lines() -> List[str]:
    """A line for each entry of KEYS."""
    width = max(len(keys) for keys, _ in KEYS)
    return [f"{keys:{width}}  {action}" for keys, action in KEYS]
