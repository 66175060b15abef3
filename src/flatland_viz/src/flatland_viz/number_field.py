"""A field for a number, written with a decimal point in every locale, as in world files."""

from typing import Tuple

from python_qt_binding.QtCore import QLocale
from python_qt_binding.QtGui import QValidator
from python_qt_binding.QtWidgets import QDoubleSpinBox


class NumberField(QDoubleSpinBox):
    """A comma becomes a decimal point.

    A QDoubleSpinBox reads "1.5" as 15 in locales with a decimal comma: the point separates groups
    of digits there. In others it drops a comma, with the same result.
    """

    def __init__(self, name: str) -> None:
        super().__init__(objectName=name)
        self.setLocale(QLocale.c())

    def validate(self, text: str, cursor: int) -> Tuple[QValidator.State, str, int]:
        """Checks what is typed."""
        state, text, cursor = super().validate(text.replace(",", "."), cursor)
        return state, text, cursor
