"""The view of a whole world: rviz's view from above, and its grid."""

from typing import Any, List, Optional

from python_qt_binding.QtCore import QObject, QRectF, Signal
from python_qt_binding.QtWidgets import QWidget

from flatland_viz.bounds import extent, framed, grid_around
from flatland_viz.world_displays import GRID, displays_of

_VIEW = ("X", "Y", "Scale", "Angle")


class Framing(QObject):
    """Frames the world when it changes or the panel is resized, until the user moves the view.

    Args:
        manager: rviz's.
        panel: the panel with the view.
        models: rviz's display of the models.
    """

    whole = Signal()
    """Walls and models are there, and framed."""

    def __init__(self, manager: Any, panel: QWidget, models: Any) -> None:
        super().__init__()
        self._manager = manager
        self._panel = panel
        self._walls = QRectF()
        self._models = models.subProp("Bounds")
        self._models.changed.connect(self._on_models)
        self._are_models_new = True
        self._framed: Optional[List[float]] = None

    def set_walls(self, walls: QRectF) -> None:
        """Sets the box around all walls [m]; null without walls."""
        self._walls = walls
        self._frame_world()

    def _on_models(self) -> None:
        """Frames new models; the view does not follow moving ones."""
        if self._models.getValue().isNull():
            self._are_models_new = True
        elif self._are_models_new:
            self._are_models_new = False
            self._frame_world()

    def _frame_world(self) -> None:
        self._place_grid()
        self.follow_size()
        if not self._walls.isNull() and not self._are_models_new:
            self.whole.emit()

    def follow_size(self) -> None:
        """Frames the world after the panel was resized, unless the user has moved the view."""
        if self._framed is None or self._view() == self._framed:
            self.reset_view()

    def reset_view(self) -> None:
        """Frames all walls and models."""
        self._place_grid()
        ratio = self._panel.devicePixelRatioF()
        view = framed(self._bounds, ratio * self._panel.width(), ratio * self._panel.height())
        controller = self._manager.getViewManager().getCurrent()
        for name, value in zip(_VIEW, (view.x, view.y, view.scale, 0.0)):
            controller.subProp(name).setValue(value)
        self._framed = self._view()
        self._manager.queueRender()

    def _view(self) -> List[float]:
        """The present view, in rviz's single precision."""
        controller = self._manager.getViewManager().getCurrent()
        return [controller.subProp(name).getValue() for name in _VIEW]

    @property
    def _bounds(self) -> QRectF:
        """The extent of the world as it is now."""
        return extent(self._walls, self._models.getValue())

    def _place_grid(self) -> None:
        grid = grid_around(self._bounds)
        for display in displays_of(self._manager, GRID):
            display.subProp("Cell Size").setValue(grid.cell_size)
            display.subProp("Plane Cell Count").setValue(grid.cells)
            display.subProp("Offset").subProp("X").setValue(grid.x)
            display.subProp("Offset").subProp("Y").setValue(grid.y)
