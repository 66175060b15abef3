"""Labels of the panels."""

from typing import Any, Optional

from python_qt_binding.QtCore import QEvent, Qt
from python_qt_binding.QtGui import QColor, QKeySequence, QPainter, QPalette, QTextDocument
from python_qt_binding.QtWidgets import QApplication, QLabel, QSizePolicy


class ElidedLabel(QLabel):
    """A line that is elided in the middle if it does not fit; its tooltip has all of it.

    It never widens its container.
    """

    def __init__(self, **properties: Any) -> None:
        super().__init__(**properties)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)

    def setText(self, text: str) -> None:  # noqa: N802
        """Sets the line."""
        super().setText(text)
        self.setToolTip(text)

    @property
    def shown_text(self) -> str:
        """The visible text."""
        metrics = self.fontMetrics()
        return str(metrics.elidedText(self.text(), Qt.ElideMiddle, self.contentsRect().width()))

    def paintEvent(self, event: QEvent) -> None:  # noqa: N802
        """Draws the line."""
        QPainter(self).drawText(self.contentsRect(), int(self.alignment()), self.shown_text)


class RichElidedLabel(QLabel):
    """A line of rich text; where it does not fit, its plain text, elided at the end.

    Its tooltip then has all of it. It never widens its container.
    """

    def __init__(self, **properties: Any) -> None:
        super().__init__(**properties)
        self.setSizePolicy(QSizePolicy.Ignored, QSizePolicy.Preferred)
        self._rich = ""
        self._width = 0
        self._plain = ""

    def show_rich(self, text: str) -> None:
        """Sets the line."""
        if text == self._rich:
            return
        self._rich = text
        document = QTextDocument()
        document.setDefaultFont(self.font())
        document.setHtml(text)
        self._width, self._plain = int(document.idealWidth()), document.toPlainText()
        self._fit()

    def resizeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Shows as much as fits."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        width = self.contentsRect().width()
        fits = self._width <= width
        self.setTextFormat(Qt.RichText if fits else Qt.PlainText)
        elided = self.fontMetrics().elidedText(self._plain, Qt.ElideRight, width)
        self.setText(self._rich if fits else elided)
        self.setToolTip("" if fits else self._plain)


class QuietLabel(QLabel):
    """A caption in a muted colour, on light and dark backgrounds."""

    def __init__(self, text: str, **properties: Any) -> None:
        super().__init__(text, **properties)
        self._color: Optional[QColor] = None
        self._mute()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Follows the look of the window."""
        super().changeEvent(event)
        if event.type() == QEvent.PaletteChange:
            self._mute()

    def _mute(self) -> None:
        palette = QApplication.palette()
        color = quiet(palette.color(QPalette.WindowText))
        if color != self._color:  # setting it causes the next event
            self._color = color
            own = QPalette()
            own.setColor(QPalette.WindowText, color)
            self.setPalette(own)


def quiet(color: QColor) -> QColor:
    """A muted form of a colour of text."""
    muted = QColor(color)
    muted.setAlphaF(0.62)
    return muted


class SelectableLabel(QLabel):
    """A label with text to select and copy, also where Ctrl+C is the key of an action."""

    def __init__(self, **properties: Any) -> None:
        super().__init__(**properties)
        self.setTextInteractionFlags(Qt.TextSelectableByMouse)

    def event(self, event: QEvent) -> bool:
        """Takes the key for itself while text is selected."""
        is_key = event.type() == QEvent.ShortcutOverride and event.matches(QKeySequence.Copy)
        if is_key and self.hasSelectedText():
            event.accept()
            return True
        return bool(super().event(event))
