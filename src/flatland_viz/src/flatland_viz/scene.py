"""The embedded rviz: its frame without menus, the displays, the view and the tools."""

import tempfile
from typing import Any, Dict, List, Optional, Set

import yaml
from python_qt_binding.QtCore import QObject, Qt, Signal
from python_qt_binding.QtGui import QColor, QIcon, QKeySequence
from python_qt_binding.QtWidgets import QDockWidget, QMenu, QToolBar, QWidget, QWidgetAction
from rviz import bindings as rviz

from flatland_viz.bounds import EMPTY_WORLD, Bounds, bounds_in, extent, framed, grid_around
from flatland_viz.displays import COLORED, GOAL, PLAN, WALLS, Shown, changes, color_of
from flatland_viz.drawing import limit_anti_aliasing, render_on_change
from flatland_viz.navigation_tools import NavigationTool, show_tools
from flatland_viz.rviz_config import INTERACT_TOOL, MODELS, Config, for_window
from flatland_viz.window_ids import synchronised_window_ids

BACKGROUNDS = {"light": ("#eeeeec", 0.3), "dark": ("#121316", 0.15)}
"""Background colour and opacity of the grid, by name; grey walls stand out on both."""
_LOOKS: Dict[str, Dict[str, Any]] = {
    PLAN: {"Line Style": "Billboards", "Line Width": 0.1, "Color": QColor("#009e73")},
    GOAL: {"Shaft Length": 0.6, "Shaft Radius": 0.08, "Head Length": 0.5, "Head Radius": 0.3},
}
"""Properties of rviz's own displays, by their classes."""
_VIEW = ("X", "Y", "Scale", "Angle")
SPAWN_TOOL = "flatland_viz/SpawnModel"
RATE_TOOL = "flatland_viz/ChangeRate"


class Scene(QObject):
    """Controls the embedded rviz.

    Args:
        base: the rviz configuration to start from.
        frame_rate: how often the view is drawn [Hz].
    """

    walls_progress = Signal(int)
    """Percent of the walls that are shown."""
    whole = Signal()
    """Walls and models are there, and framed."""

    def __init__(self, base: Config, frame_rate: int) -> None:
        super().__init__()
        self._displays: Dict[Shown, Any] = {}
        self._extra: Dict[str, Any] = {}
        self._colors: Dict[str, str] = {}
        self._hidden_kinds: Set[str] = set()
        self._walls: Optional[Bounds] = None
        self._are_models_new = True
        self._bounds = EMPTY_WORLD
        self._framed: Optional[List[float]] = None
        self.frame = rviz.VisualizationFrame()
        self.frame.setSplashPath("")
        with tempfile.NamedTemporaryFile("w", suffix=".rviz") as file:
            yaml.safe_dump(for_window(base, frame_rate), file)
            file.flush()
            with synchronised_window_ids():
                limit_anti_aliasing()
                self.frame.initialize(file.name)
        self._manager = self.frame.getManager()
        render_on_change(self._manager)
        self._model_bounds = self.models.subProp("Bounds")
        self._model_bounds.changed.connect(self._on_model_bounds)
        self._tools = self._manager.getToolManager()
        self.panel = next(
            widget
            for widget in self.frame.findChildren(QWidget)
            if widget.metaObject().className() == "rviz::RenderPanel"
        )
        self.hints = self._manager.statusUpdate  # the tools' hints for the mouse
        self._strip()

    def _strip(self) -> None:
        """Hides all of rviz's own window but the toolbar and the view."""
        self.frame.setWindowFlags(Qt.Widget)
        self.frame.setWindowIcon(QIcon())  # of the application, for the tools' dialogs, too
        self.frame.menuBar().hide()
        for menu in self.frame.menuBar().findChildren(QMenu):
            for action in menu.actions():
                action.setShortcut(QKeySequence())  # the window has its own
        self.frame.statusBar().hide()
        self.frame.setHideButtonVisibility(False)
        self.panel.setObjectName("view")
        self.panel.setMinimumSize(200, 150)
        for dock in self.docks:
            dock.setObjectName(f"panel_{dock.windowTitle().lower().replace(' ', '_')}")
            dock.hide()
        [toolbar] = self.frame.findChildren(QToolBar)
        toolbar.setMovable(False)
        toolbar.setContextMenuPolicy(Qt.PreventContextMenu)
        for action in toolbar.actions():
            # They add and remove tools, which would not be saved. Tools added later have neither
            # separator nor widget.
            if action.isSeparator() or isinstance(action, QWidgetAction):
                action.setVisible(False)

    @property
    def toolbar(self) -> QToolBar:
        """The toolbar with rviz's tools."""
        [toolbar] = self.frame.findChildren(QToolBar)
        return toolbar

    @property
    def tools(self) -> List[Any]:
        """Rviz's tools, in the order of the toolbar."""
        return [self._tools.getTool(index) for index in range(self._tools.numTools())]

    @property
    def docks(self) -> List[QDockWidget]:
        """The panels of rviz, hidden at first."""
        docks: List[QDockWidget] = self.frame.findChildren(QDockWidget)
        return docks

    def show_displays(self, wanted: List[Shown]) -> None:
        """Adds and removes displays so that these are shown; unchanged ones are not touched."""
        gone, new = changes(self._displays, wanted)
        root = self._manager.getRootDisplayGroup()
        for shown in gone:
            display = self._displays.pop(shown)
            display.setEnabled(False)
            root.takeDisplay(display).deleteLater()
        for shown in new:
            display = self._manager.createDisplay(shown.kind, shown.name, False)
            for name, value in _LOOKS.get(shown.kind, {}).items():
                display.subProp(name).setValue(value)
            display.subProp("Topic").setValue(shown.topic)
            self._displays[shown] = display
            if shown.kind == WALLS:
                self._follow_walls(display)
            self._apply_switches(shown)
            self._apply_color(shown)

    def show_markers(self, name: str, topic: str) -> None:
        """Shows the markers of a topic in a display of this name; an empty topic removes it."""
        display = self._extra.pop(name, None)
        if display is not None:
            display.setEnabled(False)
            self._manager.getRootDisplayGroup().takeDisplay(display).deleteLater()
        if topic:
            display = self._manager.createDisplay("rviz/Marker", name, True)
            display.subProp("Marker Topic").setValue(topic)
            self._extra[name] = display

    def _follow_walls(self, display: Any) -> None:
        """Follows the bounds and the progress that the walls' display reports.

        The properties are kept: only referenced by slots of their own, they would be garbage to
        Python, which would clear those slots while they are connected.
        """
        bounds, progress = display.subProp("Bounds"), display.subProp("Progress")
        self._walls_properties = (bounds, progress)
        bounds.changed.connect(lambda: self._on_walls(bounds_in(bounds.getValue())))
        progress.changed.connect(lambda: self.walls_progress.emit(progress.getValue()))

    def show_kinds(self, on: bool, *kinds: str) -> None:
        """Shows or hides the displays of classes, or those with these names."""
        self._hidden_kinds = self._hidden_kinds - {*kinds} if on else self._hidden_kinds | {*kinds}
        for shown in self._displays:
            self._apply_switches(shown)

    def set_colors(self, colors: Dict[str, str]) -> None:
        """Sets the colours of scans, plans and goals: `#rrggbb` by topic or namespace."""
        self._colors = colors
        for shown in self._displays:
            self._apply_color(shown)

    def _apply_switches(self, shown: Shown) -> None:
        is_wanted = shown.name not in self._hidden_kinds and shown.kind not in self._hidden_kinds
        if self._displays[shown].isEnabled() != is_wanted:
            self._displays[shown].setEnabled(is_wanted)

    def _apply_color(self, shown: Shown) -> None:
        color = color_of(shown.topic, self._colors) if shown.kind in COLORED else ""
        if color:
            self._displays[shown].subProp("Color").setValue(QColor(color))

    def follow(self, model: str) -> None:
        """Makes the view follow a model by its name; the empty string ends that."""
        self._manager.getViewManager().getCurrent().subProp("Follow").setValue(model)

    def begin_again(self) -> None:
        """Discards the displayed data of a previous run, and subscribes again."""
        self._manager.resetTime()

    def _on_walls(self, walls: Optional[Bounds]) -> None:
        self._walls = walls
        self._frame_world()

    def _on_model_bounds(self) -> None:
        """Frames new models; the view does not follow moving ones."""
        models = bounds_in(self._model_bounds.getValue())
        if models is None:
            self._are_models_new = True
        elif self._are_models_new:
            self._are_models_new = False
            self._frame_world()

    def _frame_world(self) -> None:
        self._measure()
        self.follow_size()
        if self._walls is not None and not self._are_models_new:
            self.whole.emit()

    def _measure(self) -> None:
        """Determines the extent of the world as it is now."""
        bounds = extent(self._walls, bounds_in(self._model_bounds.getValue()))
        if bounds != self._bounds:
            self._bounds = bounds
            self._place_grid()

    def follow_size(self) -> None:
        """Frames the world after the panel was resized, unless the user has moved the view."""
        if self._framed is None or self._view() == self._framed:
            self.reset_view()

    def reset_view(self) -> None:
        """Frames all walls and models."""
        self._measure()
        ratio = self.panel.devicePixelRatioF()
        view = framed(self._bounds, ratio * self.panel.width(), ratio * self.panel.height())
        controller = self._manager.getViewManager().getCurrent()
        for name, value in zip(_VIEW, (view.x, view.y, view.scale, 0.0)):
            controller.subProp(name).setValue(value)
        self._framed = self._view()
        self._manager.queueRender()

    def _view(self) -> List[float]:
        """The present view, in rviz's single precision."""
        controller = self._manager.getViewManager().getCurrent()
        return [controller.subProp(name).getValue() for name in _VIEW]

    def _place_grid(self) -> None:
        grid = grid_around(self._bounds)
        for display in self._grids():
            display.subProp("Cell Size").setValue(grid.cell_size)
            display.subProp("Plane Cell Count").setValue(grid.cells)
            display.subProp("Offset").subProp("X").setValue(grid.x)
            display.subProp("Offset").subProp("Y").setValue(grid.y)

    def _grids(self) -> List[Any]:
        return self._displays_of("rviz/Grid")

    def _displays_of(self, class_id: str) -> List[Any]:
        root = self._manager.getRootDisplayGroup()
        displays = [root.getDisplayAt(index) for index in range(root.numDisplays())]
        return [display for display in displays if display.getClassId() == class_id]

    @property
    def models(self) -> Any:
        """The display of the models."""
        [display] = self._displays_of(MODELS)
        return display

    def set_background(self, name: str) -> None:
        """Sets the background, one of `BACKGROUNDS`."""
        color, grid_alpha = BACKGROUNDS[name]
        options = self._manager.getRootDisplayGroup().subProp("Global Options")
        options.subProp("Background Color").setValue(QColor(color))
        for grid in self._grids():
            grid.subProp("Alpha").setValue(grid_alpha)

    def show_navigation_tools(self, wanted: List[NavigationTool]) -> None:
        """Shows these of the tools for navigation."""
        show_tools(self._tools, wanted)

    def _tool(self, class_id: str) -> Any:
        tools = [self._tools.getTool(index) for index in range(self._tools.numTools())]
        return next((tool for tool in tools if tool.getClassId() == class_id), None)

    @property
    def interact_tool(self) -> Any:
        """The tool that selects and drags models."""
        return self._tool(INTERACT_TOOL)

    @property
    def spawn_tool(self) -> Any:
        """The tool that spawns models; None without it."""
        return self._tool(SPAWN_TOOL)

    @property
    def can_spawn(self) -> bool:
        """True if the tool that spawns models is available."""
        tool = self.spawn_tool
        return tool is not None and _child(tool.getPropertyContainer(), "Model File") is not None

    def spawn(self) -> None:
        """Opens the palette of the tool that spawns models."""
        self.use_tool(SPAWN_TOOL)

    def use_tool(self, class_id: str) -> None:
        """Begins to use a tool."""
        self.leave_tool()
        self._tools.setCurrentTool(self._tool(class_id))

    def leave_tool(self) -> None:
        """Ends what a tool does, as Escape in the view does."""
        self._tools.setCurrentTool(self._tools.getDefaultTool())


def _child(parent: Any, name: str) -> Any:
    """A property by name, or None; subProp would log an error for a missing one."""
    children = [parent.childAt(index) for index in range(parent.numChildren())]
    return next((child for child in children if child.getName() == name), None)
