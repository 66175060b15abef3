"""Warnings about worlds that can be loaded, but are probably not meant to be as they are.

Those that concern one value are given where it is read (`YamlReader.warn`). Here are those for
which several parts of a world are compared. They cost nothing after loading.
"""

import math
from typing import Dict, List, Mapping, Sequence, Set, Tuple
from weakref import WeakValueDictionary

import numpy as np

from flatland_server.array_math import from_segments, is_enclosed
from flatland_server.arrays import FloatArray
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import PLUGIN_ERRORS, listed
from flatland_server.geometry import Point, Pose
from flatland_server.models.collision_filter_registry import ALL
from flatland_server.models.entity import Entity
from flatland_server.models.footprint import Circle, Footprint
from flatland_server.models.layer import Layer
from flatland_server.models.model import Model, ModelConfig
from flatland_server.models.model_body import BodyConfig
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin import Plugin
from flatland_server.simulation.world_config import ModelEntry, WorldConfig
from flatland_server.simulation.world_contents import WorldContents

_NEAREST = 1e-3  # m; the core's limit
_TOUCH = 0.01  # m between footprints that are one
_LARGEST_MODEL = 100.0  # m, in a world without walls
_SMALLEST_ROOM = 10.0  # m
_FARTHEST = 50.0  # m from all walls


_checked: "WeakValueDictionary[int, WorldConfig]" = WeakValueDictionary()
"""The worlds for which warnings were given, by their ids."""


def warn_of_traps(contents: WorldContents) -> None:
    """Warns about a world after its plugins have started: once after its files were read."""
    config = contents.config
    if _checked.get(id(config)) is config:
        return
    _checked[id(config)] = config
    room = _Room(contents.layers)
    before: Dict[Entity, None] = dict.fromkeys(contents.layers)
    for entry in config.models:
        model = contents.models.get(entry.name)
        if model is None:  # a plugin has deleted it
            continue
        plugins = contents.plugins.plugins_of(entry.name)
        is_robot = any(_overrides(each, "command") for each in plugins)
        if not _warn_of_size(entry, room):
            _warn_of_place(entry, model, before, is_robot)
        _warn_of_mass(entry.model)
        warn_of_sensors(entry.model, plugins)
        before[model] = None


class _Room:
    """The bounding box of all walls [m]."""

    def __init__(self, layers: Sequence[Layer]) -> None:
        corners = [each.segments.reshape(-1, 2) for each in layers if len(each.segments)]
        self.is_open = not corners
        ends: List[FloatArray] = [end for each in corners for end in (each.min(0), each.max(0))]
        self._box = np.array([np.min(ends, axis=0), np.max(ends, axis=0)] if ends else [[0, 0]] * 2)
        self.size = max(float(np.ptp(self._box, axis=0).max()), _SMALLEST_ROOM)

    def distance(self, point: Point) -> float:
        """The distance of a point outside [m]; 0 within."""
        return math.dist(point, np.clip(point, *self._box))


def _warn_of_size(entry: ModelEntry, room: _Room) -> bool:
    """Warns of a model that is too large for the room, or far outside; returns whether it is."""
    limit = _LARGEST_MODEL if room.is_open else room.size
    for body in entry.model.bodies:
        corners = [corner for each in body.footprints for corner in each.shape.outline()]
        size = max((math.hypot(*each) for each in corners), default=0.0)
        reach = math.hypot(*body.pose[:2]) + size
        if reach > limit:
            if body.reader is not None:
                where = "" if room.is_open else f", in a world of {limit:.4g} m"
                body.reader.warn(f"expected metres, found a footprint {reach:.4g} m away{where}")
            return True
    away = 0.0 if room.is_open else room.distance(entry.pose[:2])
    is_far = away > max(room.size, _FARTHEST)
    if is_far and entry.reader is not None:
        entry.reader.warn(f"expected metres, found a place {away:.4g} m outside the walls", "pose")
    return is_far


def _warn_of_mass(config: ModelConfig) -> None:
    """Warns of dynamic bodies without density, to which Box2D gives 1 kg, but no inertia."""
    for body in config.bodies:
        densities = [each.density for each in body.footprints]
        if body.type == "dynamic" and densities and not any(densities) and body.reader is not None:
            body.reader.warn("has 1 kg, and no push turns it: no footprint has a density")


def _warn_of_place(
    entry: ModelEntry, model: Model, before: Mapping[Entity, None], is_robot: bool
) -> None:
    """Warns if a model begins within walls or models, each pair of models once."""
    if entry.reader is None:
        return
    overlapping = set(model.overlapping())
    found = [each for each in before if each in overlapping] if overlapping else []
    is_pushed = ", and is pushed out"
    if is_robot and not found:
        found, is_pushed = [each for each in before if _is_in_dark_area(each, model)], ""
    if found:
        names = listed([each.description for each in found])
        entry.reader.warn(f"begins within {names}{is_pushed}", "pose")


def _is_in_dark_area(layer: Entity, model: Model) -> bool:
    """True if the middle of a model's base is in an occupied area of an image or grid."""
    if not isinstance(layer, Layer) or not layer.config.encloses:
        return False
    solid = [each for each in model.base.config.footprints if not each.sensor]
    if not any(each.layer_bits & layer.config.bits for each in solid):
        return False
    return is_enclosed(model.base.pose[:2], layer.segments)


def warn_of_sensors(config: ModelConfig, plugins: Sequence[Plugin]) -> None:
    """Warns of sensors that stay behind, and of lidars on the outline of their own model.

    Args:
        config: a model's config.
        plugins: plugins of the model, which have started.
    """
    readers = {each.name: each.reader for each in config.plugins}
    names = [each.name for each in config.bodies]
    body_of = {each.name: readers[each.name].content().get("body", names[0]) for each in plugins}
    known = [each for each in plugins if body_of[each.name] in names]  # else it means another thing
    driven = {body_of[each.name] for each in known if _overrides(each, "command")}
    held = _held_to(driven, config)
    for plugin in known:
        reader, body = readers[plugin.name].again(), body_of[plugin.name]
        if driven and body not in held and _overrides(plugin, "read"):
            drives = listed(sorted(driven))
            stays = f'no joint holds "{body}" to "{drives}", which is driven: it stays behind'
            reader.warn(stays, "body")
        if _has_lidar(plugin):
            _warn_of_own_footprints(config, body, reader)


def _has_lidar(plugin: Plugin) -> bool:
    try:
        return plugin.batch_role is not None and plugin.batch_role.lidar is not None
    except PLUGIN_ERRORS:  # it may not expect to be asked
        return False


def _overrides(plugin: Plugin, hook: str) -> bool:
    return getattr(type(plugin), hook, None) is not getattr(ModelPlugin, hook)


def _held_to(bodies: Set[str], config: ModelConfig) -> Set[str]:
    """The bodies of a model that chains of joints hold to some of them, and these."""
    held = set(bodies)
    for _ in config.joints:
        for joint in config.joints:
            if held.intersection(joint.bodies):
                held.update(joint.bodies)
    return held


def _warn_of_own_footprints(config: ModelConfig, name: str, lidar: YamlReader) -> None:
    """Warns of a lidar on the outline of a footprint, or within one of several that overlap."""
    layers = set(lidar.get_strings("layers", (ALL,)))
    origin = lidar.get_pose("origin", Pose())
    given = lidar.content().get("ignore_bodies") or ()
    ignored = [given] if isinstance(given, str) else given
    if not lidar.is_sound:
        return
    mount = next((each.pose for each in config.bodies if each.name == name), Pose())
    place = mount.compose(origin)
    around: List[Tuple[Footprint, Pose]] = []
    apart: List[Tuple[Footprint, BodyConfig]] = []
    for body in config.bodies:
        x, y, _ = body.pose.inverse().compose(place)
        for footprint in body.footprints if body.name not in ignored else ():
            names = set(footprint.layers)
            if not names or not (ALL in names | layers or names & layers) or footprint.sensor:
                continue
            if _gap(footprint, (x, y)) < _NEAREST:
                lidar.warn(
                    "is on the outline of a footprint of its own model, which it therefore does "
                    'not see; write "layers: []" for that footprint, or put the lidar elsewhere',
                    "origin",
                )
                return
            if _contains(footprint, (x, y)):
                around.append((footprint, body.pose))
            else:
                apart.append((footprint, body))
    for footprint, body in apart:
        for other, pose in around:
            relative = pose.inverse().compose(body.pose)
            points = [relative.apply(x, y) for x, y in _outline(footprint)]
            if any(_contains(other, point) or _gap(other, point) < _TOUCH for point in points):
                lidar.warn(
                    "is inside a footprint of its own model, and sees another one, of "
                    f'"{body.name}", that overlaps it: write "ignore_bodies: [{body.name}]", or '
                    '"layers: []" for that footprint',
                    "origin",
                )
                return


def _outline(footprint: Footprint) -> FloatArray:
    """Points of a footprint's outline, several of each side; shape (n, 2)."""
    corners = np.array(footprint.shape.outline(), dtype=float)
    parts = np.linspace(0.0, 1.0, 8, endpoint=False)[:, None, None]
    points: FloatArray = corners + parts * (np.roll(corners, -1, axis=0) - corners)
    return points.reshape(-1, 2)


def _contains(footprint: Footprint, point: Point) -> bool:
    shape = footprint.shape
    if isinstance(shape, Circle):
        return math.dist(shape.center, point) < shape.radius
    starts = np.array(shape.vertices)
    sides, ways = np.roll(starts, -1, axis=0) - starts, np.array(point) - starts
    areas = sides[:, 0] * ways[:, 1] - sides[:, 1] * ways[:, 0]
    return bool((areas > 0.0).all() or (areas < 0.0).all())


def _gap(footprint: Footprint, point: Point) -> float:
    """The distance of a point to the outline of a footprint [m]."""
    shape = footprint.shape
    if isinstance(shape, Circle):
        return abs(math.dist(shape.center, point) - shape.radius)
    starts = np.array(shape.vertices, dtype=float)
    sides = np.hstack([starts, np.roll(starts, -1, axis=0)])
    away = from_segments(np.array([point]), sides)
    return float(np.hypot(away[..., 0], away[..., 1]).min())
