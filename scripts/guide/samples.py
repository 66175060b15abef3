"""Small files in which each kind of world, layer, model and plugin occurs, for `key_reads`."""

import xml.etree.ElementTree as ElementTree
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Tuple

import yaml
from key_reads import Key, Observation, observed
from PIL import Image

from flatland_server.testing import WorldFiles

ROOT = Path(__file__).resolve().parents[2]
DECLARATIONS = ROOT / "src/flatland_plugins/flatland_plugins.xml"

SAMPLES = yaml.safe_load(Path(__file__).with_name("samples.yaml").read_text(encoding="utf-8"))
TRICYCLE: Dict[str, Any] = SAMPLES["tricycle"]
PLUGINS: Dict[str, List[Dict[str, Any]]] = SAMPLES["plugins"]
"""Sample entries by plugin class, without the keys that every plugin has."""

WORLD: Dict[str, Any] = {
    "properties": {},
    "layers": [{"name": "map", "map": "walls.yaml"}, {"name": "picture", "map": "picture.yaml"}],
    "models": [{"name": "robot", "model": "robot.model.yaml"}],
}
WALLS = ((-9, -9, 9, -9), (9, -9, 9, 9), (9, 9, -9, 9), (-9, 9, -9, -9))


_BASES = {
    each.get("name", ""): each.get("base_class_type", "")
    for each in ElementTree.parse(DECLARATIONS).iter("class")
}


def plugin_names() -> List[str]:
    """The classes that the package declares."""
    return list(_BASES)


def is_of_the_world(name: str) -> bool:
    """True if a plugin's entry is in a world file."""
    return _BASES[name].endswith("WorldPlugin")


def _files() -> WorldFiles:
    files = WorldFiles()
    files.walls("walls", *WALLS)
    files.write("people.csv", "0 1 2 2\n")
    Image.new("L", (4, 4), 255).save(files.folder / "picture.png")
    files.write(
        "picture.yaml",
        "image: picture.png\nresolution: 1\norigin: [0, 0, 0]\noccupied_thresh: 0.5\n",
    )
    return files


def _observed(name: str, entries: Dict[str, Dict[str, Any]]) -> Observation:
    """The getter calls for entries of a plugin, by the plugin's name; each is read by itself."""
    files = _files()
    with observed() as observation:
        for index, (entry_name, sample) in enumerate(entries.items()):
            plugins = [{"type": name, "name": entry_name, **sample}]
            of_world = plugins if is_of_the_world(name) else []
            bodies = TRICYCLE["bodies"][:: -1 if index % 2 else 1]  # another one is the first
            model = {**TRICYCLE, "bodies": bodies, "plugins": [] if of_world else plugins}
            files.write("robot.model.yaml", model)
            files.load({**WORLD, "plugins": of_world}).world.close()
    return observation


def _file_of(name: str) -> str:
    return "world.yaml" if is_of_the_world(name) else "robot.model.yaml"


@lru_cache(maxsize=None)
def keys_of_plugin(name: str) -> List[Key]:
    """The keys of a plugin, but for those that every plugin has."""
    entries = {f"plugin{index}": sample for index, sample in enumerate(PLUGINS[name])}
    keys = _observed(name, entries).keys(_file_of(name), "plugins[]")
    return [key for key in keys if key.name not in ("type", "name", "enabled")]


def defaults_of_plugin(name: str) -> Dict[str, Any]:
    """The defaults of a plugin's keys by their paths, without those in lists of maps."""
    observation = _observed(name, {"plugin": PLUGINS[name][0]})
    return observation.defaults(_file_of(name), "plugins[]")


MAPS: Dict[str, Tuple[str, str]] = {
    "world": ("world.yaml", ""),
    "model": ("robot.model.yaml", ""),
    "image": ("picture.yaml", ""),
    "lines": ("walls.yaml", ""),
}
"""By kind of file: the sample file, and the path in it."""


@lru_cache(maxsize=None)
def keys_of_file(kind: str) -> List[Key]:
    """The keys of a kind of file, but for those of a plugin's own."""
    files = _files()
    plugin = {"type": "DummyModelPlugin", "name": "plugin"}
    world_plugin = {"type": "DummyWorldPlugin", "name": "plugin"}
    first, *others = TRICYCLE["bodies"]
    bodies = [{**first, "footprints": [SAMPLES["disc"], SAMPLES["square"]]}, *others]
    files.write("robot.model.yaml", {**TRICYCLE, "bodies": bodies, "plugins": [plugin]})
    with observed() as observation:
        files.load({**WORLD, "plugins": [world_plugin]}).world.close()
    return observation.keys(*MAPS[kind])
