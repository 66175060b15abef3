"""All kinds of markers of a world, for tests with ROS and without."""

from pathlib import Path

from flatland_server.messages import wire_form
from flatland_server.messages.model_markers import ModelMarkers, preview
from flatland_server.messages.serialized_markers import DELETE_ALL, array_of, serialized
from flatland_server.messages.wall_markers import flat_walls, upright_walls
from flatland_server.testing import WorldFiles


def markers_of_a_world(folder: Path) -> str:
    """The serialized markers of a model, of its preview and of walls."""
    files = WorldFiles(folder)
    layer = {"name": "map", "map": files.walls("map", (5, 0, 6, 2))}
    world = files.load_models({"robot": {"model": files.model("robot")}}, [layer]).world
    markers = ModelMarkers(world.models["robot"])
    markers.place()
    walls = world.layers[0]
    parts = (
        markers.bytes(),
        serialized(preview(world.models["robot"].config)),
        flat_walls(walls.config, walls.segments),
        upright_walls(walls.config, walls.segments),
        DELETE_ALL,
    )
    return wire_form.serialized(array_of(parts)).hex()
