"""The screens on which the window is tested: sizes, pixels per pixel of Qt's, light and dark."""

from argparse import ArgumentTypeError
from functools import lru_cache
from typing import Dict, List, NamedTuple, Tuple

Color = Tuple[int, int, int]


class ScreenKind(NamedTuple):
    """A screen, and the background of the window's view on it.

    Attributes:
        width: in pixels.
        height: in pixels.
        scale: pixels per device-independent pixel of Qt.
        is_dark: whether the background is dark.
    """

    width: int
    height: int
    scale: int
    is_dark: bool

    @property
    def background(self) -> Color:
        """The colour of the view's background."""
        return (18, 19, 22) if self.is_dark else (238, 238, 236)

    @property
    def walls(self) -> Color:
        """The colour of grey walls in the window: lighter on a dark background."""
        return (147, 147, 147) if self.is_dark else (102, 102, 102)

    @property
    def plate(self) -> Color:
        """The colour behind names on the map."""
        return (35, 38, 42) if self.is_dark else (252, 252, 252)

    @property
    def paper(self) -> Color:
        """The colour behind the text of lists and fields."""
        return (30, 31, 34) if self.is_dark else (255, 255, 255)

    def mixed(self, color: Color, alpha: float) -> Color:
        """The visible colour of a transparent one on the background."""
        red, green, blue = (
            round(alpha * value + (1 - alpha) * behind)
            for value, behind in zip(color, self.background)
        )
        return red, green, blue


_SIZES = {"1280x800": (1280, 800, 1), "1024x700": (1024, 700, 1), "2x": (1280, 800, 2)}
SCREENS = {
    f"{name}-{look}": ScreenKind(*size, look == "dark")
    for name, size in _SIZES.items()
    for look in ("light", "dark")
}
"""By name. At "2x", the window has 640 x 400 pixels of Qt's."""

USUAL: Dict[str, Dict[str, str]] = {
    "test_gui_fits": {"window": "2x-light"},
    "test_gui_life": {"window": "1280x800-light"},
    "test_gui_scene": {"window": "2x-dark"},
    "test_gui_viewers": {"window": "1280x800-dark", "rviz": "1024x700-light"},
    "test_gui_window": {"window": "1024x700-dark"},
}
"""The screen of each test module's viewers, unless --screens says otherwise: together all six."""


def screens_option(value: str) -> str:
    """The value of --screens, for argparse: "all", "usual", or names with commas between them.

    Raises:
        ArgumentTypeError: there is no such screen.
    """
    unknown = set(value.split(",")) - {"all", "usual", *SCREENS}
    if unknown:
        raise ArgumentTypeError(
            f"expected all or some of {', '.join(SCREENS)}; found {', '.join(sorted(unknown))}"
        )
    return value


@lru_cache(maxsize=None)  # pytest keeps a fixture from test to test if it gets the same object
def chosen(module: str, option: str) -> List[Tuple[str, str]]:
    """The viewers of a test module, each with the name of its screen."""
    if option == "usual":
        return list(USUAL[module].items())
    names = list(SCREENS) if option == "all" else option.split(",")
    return [(viewer, name) for viewer in USUAL[module] for name in names]
