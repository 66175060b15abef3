"""The timeline below the view: a slider over the times of the run that the server has kept."""

from typing import Any, Optional

from python_qt_binding.QtCore import Qt, Signal
from python_qt_binding.QtGui import QMouseEvent
from python_qt_binding.QtWidgets import QLabel, QSlider, QStyle, QToolBar

from flatland_viz.status import Simulation

_RESOLUTION = 0.01  # s
_SPACE = 12  # pixels
_TIP = "Go back in time: drag the knob. The simulation pauses; Resume goes on from there."


class _Slider(QSlider):
    """A slider with a knob that moves to the place of a click."""

    def __init__(self) -> None:
        super().__init__(Qt.Horizontal, objectName="timeline_slider")
        self.setFocusPolicy(Qt.NoFocus)  # arrow keys drive robots

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Moves the knob to the mouse; Qt then drags it from there."""
        if event.button() == Qt.LeftButton:
            knob = self.style().pixelMetric(QStyle.PM_SliderLength, None, self)
            self.setSliderPosition(
                QStyle.sliderValueFromPosition(
                    self.minimum(), self.maximum(), event.x() - knob // 2, self.width() - knob
                )
            )
        super().mousePressEvent(event)


class Timeline(QToolBar):
    """A toolbar with the slider; disabled if the server keeps no history."""

    sought = Signal(float)
    """The time to go to [s], when the knob is released."""

    def __init__(self) -> None:
        super().__init__("Timeline", objectName="timeline")
        self.setMovable(False)
        self.setFloatable(False)
        self.toggleViewAction().setEnabled(False)
        self._begin = self._end = 0.0
        self._slider = _Slider()
        self._slider.sliderPressed.connect(self._show_time)
        self._slider.sliderMoved.connect(lambda _: self._show_time())
        self._slider.sliderReleased.connect(lambda: self.sought.emit(self._time))
        self._label = QLabel(objectName="timeline_time")
        width = self._label.fontMetrics().horizontalAdvance("10000.0 of 10000.0 s") + _SPACE
        self._label.setMinimumWidth(width)
        self._label.setAlignment(Qt.AlignRight | Qt.AlignVCenter)
        self._slider.setToolTip(_TIP)
        self.addWidget(self._slider)
        self.addWidget(self._label)
        self.show_simulation(None)

    def contextMenuEvent(self, event: Any) -> None:  # noqa: N802
        """No menu: it would hide the toolbar."""

    @property
    def _time(self) -> float:
        """The time at the knob [s]."""
        return min(self._begin + float(self._slider.sliderPosition()) * _RESOLUTION, self._end)

    def show_simulation(self, simulation: Optional[Simulation]) -> None:
        """Shows the present time, unless the knob is held; None: there is no server."""
        has_history = simulation is not None and simulation.end > simulation.begin
        self._slider.setEnabled(has_history)
        if simulation is None or self._slider.isSliderDown():
            return
        self._begin, self._end = simulation.begin, simulation.end
        self._slider.setRange(0, max(1, round((self._end - self._begin) / _RESOLUTION)))
        position = round((simulation.time - self._begin) / _RESOLUTION)
        self._slider.setValue(position if has_history else self._slider.maximum())
        self._show_time()

    def _show_time(self) -> None:
        is_past = self._time < self._end - _RESOLUTION
        self._label.setText(f"{self._time:.1f} of {self._end:.1f} s" if is_past else "")
