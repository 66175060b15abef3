"""Cases with large maps: loading time and memory."""

import tempfile
import time
from functools import partial
from pathlib import Path

from flatland_benchmark.case import Case, Figures
from flatland_benchmark.figures import peak_memory
from flatland_benchmark.scenes import write_noisy_map
from flatland_server.simulation.world import World

_SPECKS = 0.006
"""Share of black pixels in a very noisy map, of about 400,000 segments."""


def load(worlds: Path, simplify_map: int) -> Figures:
    """Loads a very noisy map of 200 x 200 m, with exact or simplified outlines."""
    with tempfile.TemporaryDirectory() as folder:
        map_file = write_noisy_map(Path(folder), _SPECKS)
        path = Path(folder, "world.yaml")
        path.write_text(f"properties: {{}}\nlayers: [{{name: map, map: {map_file}}}]\n")
        begin = time.perf_counter()
        world = World.from_file(path, simplify_map=simplify_map)
        seconds = time.perf_counter() - begin
    return {"segments": len(world.layers[0].segments), "load [s]": seconds, **peak_memory()}


MAP_CASES = (
    Case("load_large_map", "a map with 400,000 segments is loaded", partial(load, simplify_map=0)),
    Case(
        "load_large_map_simplified",
        "the same with outlines simplified within one pixel",
        partial(load, simplify_map=1),
    ),
)
