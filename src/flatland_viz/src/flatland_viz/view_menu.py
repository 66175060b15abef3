"""The menu View: what the view shows, the look of the window, and its panels."""

from functools import partial
from typing import List

from python_qt_binding.QtWidgets import QActionGroup, QDockWidget, QMenu, QWidget

from flatland_viz.actions import add_action, add_switch
from flatland_viz.displays import FOOTPRINTS, GOAL, PLAN, SCAN
from flatland_viz.scene import BACKGROUNDS, Scene
from flatland_viz.theme import Theme
from flatland_viz.trail_display import TrailDisplay


class ViewMenu(QMenu):
    """Switches of models and of navigation, the look, and panels.

    Args:
        window: window with the panels.
        scene: the embedded rviz.
        theme: the look of the window.
        trail: the trail of the selected model.
    """

    def __init__(self, window: QWidget, scene: Scene, theme: Theme, trail: TrailDisplay) -> None:
        super().__init__("&View", window)
        self._scene = scene
        self._theme = theme
        names, headings = (scene.models.subProp(each) for each in ("Labels", "Headings"))
        add_switch(self, "&Names", "labels", names.setValue, "N")
        add_switch(self, "H&eadings", "headings", headings.setValue)
        add_switch(self, "&Scans", "scans", lambda on: scene.displays.show_kinds(on, SCAN), "L")
        add_switch(
            self, "&Plans and goals", "plans", lambda on: scene.displays.show_kinds(on, PLAN, GOAL)
        )
        add_switch(
            self, "&Footprints", "footprints", lambda on: scene.displays.show_kinds(on, FOOTPRINTS)
        )
        shows_trail = add_switch(self, "T&rail", "trail", lambda on: None, "T")
        shows_trail.setChecked(False)
        shows_trail.toggled.connect(trail.switch)
        self.addSeparator()
        add_action(self, "Show the &whole world", scene.framing.reset_view, "Home")
        looks = self.addMenu("&Colours")
        group = QActionGroup(looks)
        for name in BACKGROUNDS:
            look = add_action(looks, f"&{name.capitalize()}", partial(self._set_look, name))
            look.setObjectName(f"action_background_{name}")
            look.setCheckable(True)
            look.setChecked(name == "light")
            group.addAction(look)
        self.addSeparator()

    def _set_look(self, name: str) -> None:
        self._scene.set_background(name)
        self._theme.apply(name)

    def add_panels(self, panels: List[QDockWidget]) -> None:
        """Adds actions that show and hide the toolbar and panels."""
        toolbar = self._scene.toolbar.toggleViewAction()
        toolbar.setText("&Toolbar")
        toolbar.setObjectName("")  # its state is part of the layout
        self.addActions([toolbar, *(panel.toggleViewAction() for panel in panels)])
