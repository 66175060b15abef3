"""Saving the state of a world, and putting a world into a saved state."""

from dataclasses import asdict, replace
from operator import attrgetter
from pathlib import Path
from typing import Any, Dict, Iterator, List, Sequence, Union

from flatland_server import plain_data
from flatland_server.exceptions import FlatlandError, StateError
from flatland_server.geometry import Pose
from flatland_server.models.footprint import Circle, Polygon
from flatland_server.models.model import ModelText
from flatland_server.simulation import plugin_state
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry, ModelSource, WorldConfig
from flatland_server.simulation.world_state import (
    FootprintState,
    ModelState,
    WallsState,
    WorldState,
)
from flatland_server.timekeeper import Timekeeper


def save(world: World, timekeeper: Timekeeper) -> WorldState:
    """The present state of a world, which each one that restores it continues bit for bit.

    Raises:
        StateError: a plugin's state cannot be saved, or a model has no file that it could be read
            from again.
    """
    contents = world.contents
    contents.plugins.schedule.pass_over(timekeeper.nanoseconds - timekeeper.step_nanoseconds)
    return replace(
        parts_of(world),
        nanoseconds=timekeeper.nanoseconds,
        plugins=plugin_state.collect(contents.plugins),
        physics=contents.physics.save_state(),
    )


def parts_of(world: World) -> WorldState:
    """A state with the models, walls and footprints of a world alone.

    Raises:
        StateError: a model has no file that it could be read from again.
    """
    contents = world.contents
    return WorldState(
        str(contents.config.path or ""),
        contents.seed,
        0,
        _wall_counts(contents.config),
        contents.added.states_of(contents.models),
        {name: list(pose) for name, pose in contents.layout.items()},
        contents.added.walls,
        list(_footprints(world)),
        [],
        b"",
    )


def restore(state: WorldState, world: World) -> None:
    """Puts a world that was just made, with the state's seed, into a state.

    Raises:
        StateError: the state does not fit, or the file of a model is missing.
    """
    contents = world.contents
    for own, what in ((state.own_walls, "walls"), (state.vary, "values")):
        if own is not None:
            raise StateError(
                f"the state is of an environment with {what} of its own: load it in a batch"
            )
    try:
        _check_walls(state, contents.config)
        _replay_added(state, world)
        contents.layout = {name: Pose(*pose) for name, pose in state.layout.items()}
        for footprint in state.footprints:
            _restore_footprint(footprint, world)
        plugins = state.plugins
        if state.is_of_batch:  # which leaves out some: they start from scratch
            plugins = plugin_state.completed(contents.plugins, plugins)
        with contents.deferred.lock:  # what they did to models when they ended is in the state
            plugin_state.restore_failures(contents.plugins, plugins)
        contents.deferred.pending.clear()
        contents.physics.restore_state(state.physics)
        plugin_state.restore(contents.plugins, plugins)
    except StateError:
        raise
    except (FlatlandError, ValueError) as error:
        raise StateError(f"the state cannot be restored: {error}") from error


def require_same_parts(state: WorldState, other: WorldState, config: WorldConfig) -> None:
    """Checks that two states are of worlds with equal models, walls and footprints.

    Raises:
        StateError: they are not.
    """
    _check_walls(state, config)
    for noun in ("models", "walls", "footprints"):
        found, expected = _parts(getattr(state, noun)), _parts(getattr(other, noun))
        if plain_data.dumps(found) != plain_data.dumps(expected):
            raise StateError(
                f"the state is of another world: {noun} were added, changed or deleted; expected "
                f"the models {_names(other.models)}, found {_names(state.models)}"
            )


def _names(models: Sequence[Union[ModelEntry, ModelState]]) -> str:
    """The names of models with their namespaces."""
    return ", ".join(
        f"{each.name} ({each.namespace})" if each.namespace else each.name for each in models
    )


def _parts(entries: Sequence[Any]) -> List[Dict[str, Any]]:
    """The entries as dicts to compare, without the number of times that models were moved."""
    return [{**asdict(each), "move_revision": 0} for each in entries]


def _footprints(world: World) -> Iterator[FootprintState]:
    """The footprints of models that have changed ones."""
    for model in world.models.values():
        for body in model.bodies.values() if model.footprint_revision else ():
            for index, footprint in enumerate(body.config.footprints):
                shape, radius = footprint.shape, None
                if isinstance(shape, Circle):
                    radius, points = shape.radius, [shape.center]
                else:
                    points = list(shape.vertices)
                layers = list(footprint.layers)
                corners = [[x, y] for x, y in points]
                yield FootprintState(model.name, body.name, index, radius, corners, layers)


def _restore_footprint(state: FootprintState, world: World) -> None:
    points = [(x, y) for x, y in state.points]
    if state.radius is None:
        shape: Union[Circle, Polygon] = Polygon(tuple(points))
    else:
        [center] = points
        shape = Circle(center, state.radius)
    world.get_model(state.model).set_footprint(state.body, state.index, shape, state.layers)


def _wall_counts(config: WorldConfig) -> Dict[str, int]:
    """The number of walls of each layer in the world's files."""
    return {layer.names[0]: len(config.walls_of(layer)) for layer in config.layers}


def _check_walls(state: WorldState, config: WorldConfig) -> None:
    """Checks that a state is of a world with these maps."""
    expected, found = _wall_counts(config), state.wall_counts
    for layer in dict.fromkeys([*expected, *found]):
        if expected.get(layer) != found.get(layer):
            raise StateError(
                f'the state is of another world ({state.world}): the layer "{layer}" has '
                f"{found.get(layer, 'no')} walls there, {expected.get(layer, 'no')} here"
            )


def _source_of(model: ModelState) -> ModelSource:
    if isinstance(model.content, str):
        return ModelText(model.content, model.name)
    return Path(model.path) if model.content is None else model.content


def _replay_added(state: WorldState, world: World) -> None:
    """Deletes and adds models and walls of a rebuilt world, until it has those of a state."""
    kept = {model.name for model in state.models if model.order is None}
    for name in [name for name in world.models if name not in kept]:
        world.delete_model(name)
    added: List[Union[ModelState, WallsState]] = [*state.walls]
    added += [model for model in state.models if model.order is not None]
    for each in sorted(added, key=attrgetter("order")):
        if isinstance(each, ModelState):
            pose = Pose(*each.pose)
            world.spawn_model(_source_of(each), each.name, each.namespace, pose)
        elif 0 <= each.layer < len(world.layers):
            world.add_walls(world.layers[each.layer].name, each.segments)
    entries = world.contents.added.entries
    expected, found = _names([entries[name] for name in world.models]), _names(state.models)
    if expected != found:
        raise StateError(
            f"the state is of another world: expected the models {expected}; found {found}"
        )
    for model in state.models:
        world.models[model.name].move_revision = model.move_revision
