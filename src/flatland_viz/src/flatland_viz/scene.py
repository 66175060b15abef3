"""The embedded rviz: its frame without menus, its displays, view and tools."""

import tempfile
from typing import Any, List

import yaml
from python_qt_binding.QtCore import QObject, Qt
from python_qt_binding.QtGui import QColor, QIcon, QKeySequence
from python_qt_binding.QtWidgets import QDockWidget, QMenu, QToolBar, QWidget, QWidgetAction
from rviz import bindings as rviz

from flatland_viz.framing import Framing
from flatland_viz.native import library
from flatland_viz.navigation_tools import NavigationTool, show_tools
from flatland_viz.rviz_config import INTERACT_TOOL, MODELS, Config, for_window
from flatland_viz.window_ids import synchronised_window_ids
from flatland_viz.world_displays import GRID, WorldDisplays, displays_of

BACKGROUNDS = {"light": ("#eeeeec", 0.3), "dark": ("#121316", 0.15)}
"""Background colour and opacity of the grid, by name; grey walls stand out on both."""
_SPAWN_TOOL = "flatland_viz/SpawnModel"
_RENDER_ON_CHANGE = "flatland_viz/RenderOnChange"
"""Our display that keeps rviz from drawing an unchanged view."""


class Scene(QObject):
    """Controls the embedded rviz.

    Args:
        base: the rviz configuration to start from.
        frame_rate: how often the view is drawn [Hz].
    """

    def __init__(self, base: Config, frame_rate: int) -> None:
        super().__init__()
        self.frame = rviz.VisualizationFrame()
        self.frame.setSplashPath("")
        with tempfile.NamedTemporaryFile("w", suffix=".rviz") as file:
            yaml.safe_dump(for_window(base, frame_rate), file)
            file.flush()
            with synchronised_window_ids():
                library().flatland_viz_limit_anti_aliasing()
                self.frame.initialize(file.name)
        self._manager = self.frame.getManager()
        display = self._manager.createDisplay(_RENDER_ON_CHANGE, "render on change", True)
        display.setHidden(True)  # in the Displays panel: there is nothing to set
        self._tools = self._manager.getToolManager()
        self.panel = next(
            widget
            for widget in self.frame.findChildren(QWidget)
            if widget.metaObject().className() == "rviz::RenderPanel"
        )
        self.hints = self._manager.statusUpdate  # the tools' hints for the mouse
        [self.models] = displays_of(self._manager, MODELS)
        self.framing = Framing(self._manager, self.panel, self.models)
        self.displays = WorldDisplays(self._manager)
        self.displays.walls_changed.connect(self.framing.set_walls)
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
        self.toolbar.setMovable(False)
        self.toolbar.setContextMenuPolicy(Qt.PreventContextMenu)
        for action in self.toolbar.actions():
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

    def follow(self, model: str) -> None:
        """Makes the view follow a model by its name; the empty string ends that."""
        self._manager.getViewManager().getCurrent().subProp("Follow").setValue(model)

    def begin_again(self) -> None:
        """Discards the displayed data of a previous run, and subscribes again."""
        self._manager.resetTime()

    def set_background(self, name: str) -> None:
        """Sets the background, one of `BACKGROUNDS`."""
        color, grid_alpha = BACKGROUNDS[name]
        options = self._manager.getRootDisplayGroup().subProp("Global Options")
        options.subProp("Background Color").setValue(QColor(color))
        for grid in displays_of(self._manager, GRID):
            grid.subProp("Alpha").setValue(grid_alpha)

    def show_navigation_tools(self, wanted: List[NavigationTool]) -> None:
        """Shows these of the tools for navigation."""
        show_tools(self._tools, wanted)

    def _tool(self, class_id: str) -> Any:
        return next(tool for tool in self.tools if tool.getClassId() == class_id)

    @property
    def interact_tool(self) -> Any:
        """The tool that selects and drags models."""
        return self._tool(INTERACT_TOOL)

    @property
    def spawn_tool(self) -> Any:
        """The tool that spawns models."""
        return self._tool(_SPAWN_TOOL)

    def spawn(self) -> None:
        """Opens the palette of the tool that spawns models."""
        self.leave_tool()
        self._tools.setCurrentTool(self.spawn_tool)

    def leave_tool(self) -> None:
        """Ends what a tool does, as Escape in the view does."""
        self._tools.setCurrentTool(self._tools.getDefaultTool())
