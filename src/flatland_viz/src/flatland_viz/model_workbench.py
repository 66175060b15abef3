"""The window's parts for work with models: selection, actions, the side panel, switches."""

import json
from typing import Dict

import rospy
from python_qt_binding.QtCore import QObject, Qt
from python_qt_binding.QtWidgets import QMainWindow, QMenu

from flatland_viz.displays import FOOTPRINTS, GOAL, PLAN, SCAN
from flatland_viz.interaction import Interaction
from flatland_viz.model_actions import ModelActions
from flatland_viz.model_list import Model, topic_owners
from flatland_viz.model_panel import ModelPanel
from flatland_viz.scene import Scene
from flatland_viz.selection import Selection
from flatland_viz.server import Server
from flatland_viz.status import Simulation
from flatland_viz.status_line import StatusLine
from flatland_viz.trail_display import TrailDisplay
from flatland_viz.view_switches import ViewSwitches


class ModelWorkbench(QObject):
    """Adds these parts to the window and connects them.

    Args:
        window: gets the panel and the menu of models, and has a menu `menu_view`.
        server: the connection to the server.
        scene: the embedded rviz.
        selection: the selected model.
        line: shows messages about actions.
    """

    def __init__(
        self,
        window: QMainWindow,
        server: Server,
        scene: Scene,
        selection: Selection,
        line: StatusLine,
    ) -> None:
        super().__init__(window)
        self._scene = scene
        self._selection = selection
        self._models: Dict[str, Model] = {}
        interaction = Interaction(scene.interact_tool, scene.spawn_tool, selection)
        self._actions = ModelActions(window, server, selection, interaction, scene.follow)
        self._actions.hint.connect(line.show_hint)
        self._actions.followed.connect(line.show_followed)
        line.following_ended.connect(self._actions.end_following)
        self.panel = ModelPanel(selection, interaction, self._actions)
        window.addDockWidget(Qt.RightDockWidgetArea, self.panel)
        self._interaction = interaction
        self._colors = scene.models.subProp("Colors")
        self._colors.changed.connect(self._show_colors)
        server.models_changed.connect(self._on_models)
        server.simulation_changed.connect(self._on_simulation)
        self._add_menus(window)

    def _add_menus(self, window: QMainWindow) -> None:
        bar, view = window.menuBar(), window.findChild(QMenu, "menu_view")
        menu = QMenu("&Model", bar, objectName="menu_models")
        bar.insertMenu(view.menuAction(), menu)
        menu.addActions([self._actions.undo, self._actions.redo])
        menu.addSeparator()
        self._actions.fill(menu)
        display = self._scene.models
        ViewSwitches(
            view,
            {
                "labels": display.subProp("Labels").setValue,
                "headings": display.subProp("Headings").setValue,
                "handles": self._interaction.handles.setValue,
                "scans": lambda on: self._scene.show_kinds(on, SCAN),
                "plans": lambda on: self._scene.show_kinds(on, PLAN, GOAL),
                "footprints": lambda on: self._scene.show_kinds(on, FOOTPRINTS),
            },
        )
        states = rospy.resolve_name("flatland_server/model_states")
        self._trail = TrailDisplay(view, self._scene, self._selection, states)
        view.addAction(self.panel.toggleViewAction())

    @property
    def has_edited(self) -> bool:
        """True if models have been changed in this window since they were saved."""
        return self._actions.has_edited

    def note_saved(self) -> None:
        """Notes that all changes are in the world's file, or are gone."""
        self._actions.has_edited = False

    def _on_models(self, models: Dict[str, Model]) -> None:
        self._models = models
        self._actions.set_models(models)
        self._trail.set_models(models)  # before the panel subscribes to a topic of another type
        self.panel.set_models(models)
        self._show_colors()

    def _on_simulation(self, simulation: Simulation) -> None:
        self.panel.set_time(simulation.time)
        self._actions.show_simulation(simulation)

    def _show_colors(self) -> None:
        """Gives robots' scans, plans and goals, and the list, their colours."""
        text = self._colors.getValue()
        colors: Dict[str, str] = json.loads(text) if text else {}
        self.panel.set_colors(colors)
        owners = topic_owners(self._models)
        self._scene.set_colors(
            {topic: colors[name] for topic, name in owners.items() if name in colors}
        )
