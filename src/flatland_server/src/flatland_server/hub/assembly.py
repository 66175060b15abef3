"""Puts a served simulation together: clock, topics, services, edits, history, for all protocols."""

import logging
from typing import Optional, Tuple

from flatland_server.exceptions import StateError
from flatland_server.hub.client_files import ClientFiles
from flatland_server.hub.diagnostics import Diagnostics
from flatland_server.hub.hub import Hub
from flatland_server.hub.interactive_marker_manager import InteractiveMarkerManager
from flatland_server.hub.map_to_odom import MapToOdom
from flatland_server.hub.marker_publisher import MarkerPublisher
from flatland_server.hub.model_publisher import ModelPublisher
from flatland_server.hub.model_services import ModelServices
from flatland_server.hub.occupancy_map import OccupancyMap
from flatland_server.hub.recent_log import RecentLog
from flatland_server.hub.state_publisher import StatePublisher
from flatland_server.hub.state_services import StateServices
from flatland_server.hub.world_saving import WorldSaving
from flatland_server.simulation.history import SHARE_OF_VIEWERS
from flatland_server.simulation.pacer import WallTimekeeper
from flatland_server.simulation.simulation_manager import SimulationManager

logger = logging.getLogger(__name__)


def open_hub(
    manager: SimulationManager,
    files: ClientFiles,
    *,
    log: Optional[RecentLog] = None,
    view_rate: Optional[float] = 30.0,
    for_rviz: bool = False,
    map_to_odom: bool = True,
    with_map: bool = False,
    initial_pose: str = "",
    with_history: bool = False,
    control_period: Optional[float] = None,
    train_mode: bool = False,
    refused: Tuple[str, ...] = (),
) -> Hub:
    """Opens the topics that are not plugins', and makes the services.

    Args:
        manager: the simulation; its transport must be a `ServedTransport`.
        files: finds the files that clients name.
        log: the last warnings and errors, if clients may read them.
        view_rate: how often models are published [Hz of real time]; None for no viewers.
        for_rviz: whether each model has a topic of markers, and a handle to drag it.
        map_to_odom: whether identity stands in for a localiser.
        with_map: whether the first layer is on /map.
        initial_pose: name of the model that /initialpose moves, if it is not empty.
        with_history: whether states are kept for /seek.
        control_period: as for `StateServices`.
        train_mode: as for `StateServices`.
        refused: names of services that are not offered.

    Raises:
        UsageError: the control period is no multiple of the steps.
    """
    hub = Hub(manager, files, refused)
    if not isinstance(manager.timekeeper, WallTimekeeper):
        _open_clock(hub)
    if view_rate is not None:
        markers = MarkerPublisher(hub.world, hub.transport, view_rate, for_rviz=for_rviz)
        hub.on_tick(markers.update)
        if for_rviz:
            manager.after_jump.append(markers.time_has_jumped)
            hub.on_tick(InteractiveMarkerManager(hub, view_rate).update)
        hub.on_tick(ModelPublisher(manager, view_rate).update)
    if with_history:
        try:
            manager.keep_history(share=SHARE_OF_VIEWERS)
        except StateError as error:
            logger.warning("there is no history, so /seek will fail: %s", error)
    hub.on_tick(StatePublisher(manager, hub.edits).update)
    hub.on_tick(Diagnostics(manager).update)
    if log is not None:
        log.open(manager)
        hub.on_tick(log.update)
    if map_to_odom:
        hub.map_to_odom = MapToOdom(hub.transport, lambda: hub.world.odometry_frames)
        hub.on_tick(hub.map_to_odom.update)
    if with_map:
        hub.on_tick(OccupancyMap(hub.world, hub.transport).update)
    ModelServices(hub, initial_pose)
    StateServices(hub, control_period, train_mode)
    WorldSaving(hub)
    return hub


def _open_clock(hub: Hub) -> None:
    manager = hub.manager
    clock = hub.transport.open_clock(manager.timekeeper)

    def repeat_in_pause() -> None:
        if not manager.is_stepping:
            clock.repeat_for_new_subscribers()

    manager.after_step.append(clock.tick)
    manager.on_tick += [clock.flush, repeat_in_pause]
    manager.after_jump += [clock.tick, clock.flush]
