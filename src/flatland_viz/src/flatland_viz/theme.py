"""The light and the dark look of the whole window."""

from typing import Optional

from python_qt_binding.QtGui import QColor, QPalette
from python_qt_binding.QtWidgets import QApplication, QStyleFactory

_DARK = {
    QPalette.Window: "#2d2f33",
    QPalette.WindowText: "#e1e4e8",
    QPalette.Base: "#1e1f22",
    QPalette.AlternateBase: "#26282c",
    QPalette.Text: "#e1e4e8",
    QPalette.Button: "#3a3d42",
    QPalette.ButtonText: "#e1e4e8",
    QPalette.BrightText: "#ffffff",
    QPalette.Light: "#4d5157",
    QPalette.Midlight: "#44474d",
    QPalette.Mid: "#26282c",
    QPalette.Dark: "#1b1c1f",
    QPalette.Shadow: "#0d0e0f",
    QPalette.Link: "#56b4e9",
    QPalette.Highlight: "#0072b2",
    QPalette.HighlightedText: "#ffffff",
}
_DISABLED = "#7d8289"


class Theme:
    """Switches the application between the desktop's colours and dark ones."""

    def __init__(self) -> None:
        self._usual: Optional[QPalette] = None
        self._usual_style = ""

    def apply(self, name: str) -> None:
        """Applies "light", the colours of the desktop, or "dark"."""
        application = QApplication.instance()
        if self._usual is None:
            self._usual = application.palette()
            self._usual_style = application.style().objectName()
        is_dark = name == "dark"
        # Styles of desktops draw buttons and menus in colours of their own.
        application.setStyle(QStyleFactory.create("Fusion" if is_dark else self._usual_style))
        application.setPalette(_dark() if is_dark else self._usual)


def _dark() -> QPalette:
    palette = QPalette()
    for role, color in _DARK.items():
        palette.setColor(role, QColor(color))
    for role in (QPalette.WindowText, QPalette.Text, QPalette.ButtonText):
        palette.setColor(QPalette.Disabled, role, QColor(_DISABLED))
    return palette
