"""Random files: valid ones are read as written, others are refused with a FlatlandError."""

import contextlib
import copy
import math
from pathlib import Path
from typing import Any, Dict, Iterable, List, Tuple

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flatland_server.exceptions import FlatlandError
from flatland_server.models.footprint import Circle
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import WorldConfig

bounded = settings(
    derandomize=True,
    database=None,
    deadline=None,
    max_examples=30,
    suppress_health_check=list(HealthCheck),
)


# Functions instead of lambdas: Hypothesis parses the source of a lambda each time that it calls it.
def rounded(value: float) -> float:
    return round(value, 4)


def is_layer_name(name: str) -> bool:
    return name != "all"


NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True).filter(is_layer_name)
NUMBERS = st.floats(-100, 100, allow_nan=False).map(rounded)
POSITIVE = st.floats(0.05, 50).map(rounded)
NOT_NEGATIVE = st.floats(0, 50).map(rounded)
POSES = st.lists(NUMBERS, min_size=3, max_size=3)
POINTS = st.lists(NUMBERS, min_size=2, max_size=2)
# Box2D cannot represent a small shape that is far from the origin of its body.
NEAR_POINTS = st.lists(st.floats(-0.5, 0.5).map(rounded), min_size=2, max_size=2)
COLORS = st.lists(st.floats(0, 1).map(rounded), min_size=4, max_size=4)


def optional(**values: st.SearchStrategy) -> st.SearchStrategy:
    """A map with some of these keys."""
    return st.fixed_dictionaries({}, optional=values)


def merged(*parts: st.SearchStrategy) -> st.SearchStrategy:
    return st.tuples(*parts).map(union)


def union(maps: Iterable[Dict[str, Any]]) -> Dict[str, Any]:
    return {key: value for part in maps for key, value in part.items()}


def footprints(layers: List[str]) -> st.SearchStrategy:
    common = merged(
        st.fixed_dictionaries({"density": NOT_NEGATIVE}),
        optional(
            friction=NOT_NEGATIVE,
            restitution=NOT_NEGATIVE,
            sensor=st.booleans(),
            collision=st.booleans(),
            layers=st.lists(st.sampled_from([*layers, "all"]), max_size=3),
        ),
    )
    circle = merged(
        st.fixed_dictionaries({"type": st.just("circle"), "radius": POSITIVE}),
        optional(center=NEAR_POINTS),
    )
    # On a circle, so that it is convex.
    polygon = st.tuples(st.integers(3, 8), POSITIVE, st.booleans()).map(regular_polygon)
    return merged(circle | polygon, common)


def regular_polygon(shape: Tuple[int, float, bool]) -> Dict[str, Any]:
    corners, radius, clockwise = shape
    sign = -1 if clockwise else 1
    angles = [sign * math.tau * i / corners for i in range(corners)]
    points = [[radius * math.cos(a), radius * math.sin(a)] for a in angles]
    return {"type": "polygon", "points": points}


@st.composite
def models(draw: Any, layers: List[str]) -> Dict[str, Any]:
    names = draw(st.lists(NAMES, min_size=1, max_size=3, unique=True))
    result: Dict[str, Any] = {
        "bodies": [
            {
                "name": name,
                "footprints": draw(st.lists(footprints(layers), max_size=2)),
                **draw(
                    optional(
                        pose=POSES,
                        type=st.sampled_from(["static", "kinematic", "dynamic"]),
                        color=COLORS,
                        linear_damping=NOT_NEGATIVE,
                        angular_damping=NOT_NEGATIVE,
                        enabled=st.just(True),
                    )
                ),
            }
            for name in names
        ]
    }
    if len(names) > 1 and draw(st.booleans()):
        ends = [{"name": name, "anchor": draw(POINTS)} for name in names[:2]]
        revolute = optional(limits=st.lists(NUMBERS, min_size=2, max_size=2).map(sorted))
        weld = optional(angle=NUMBERS, frequency=NOT_NEGATIVE, damping=NOT_NEGATIVE)
        kind = draw(st.sampled_from(["revolute", "weld"]))
        result["joints"] = [
            {
                "type": kind,
                "name": draw(NAMES),
                "bodies": ends,
                **draw(revolute if kind == "revolute" else weld),
                **draw(optional(collide_connected=st.booleans(), color=COLORS)),
            }
        ]
    return result


@st.composite
def worlds(draw: Any) -> Dict[str, Any]:
    """A world, and under "model" the model file of all its entries."""
    layers = draw(st.lists(NAMES, min_size=1, max_size=5, unique=True))
    split = draw(st.integers(1, len(layers)))
    entries = [{"name": layers[:split] if split > 1 else layers[0]}]
    entries += [{"name": name} for name in layers[split:]]
    for entry in entries:
        entry.update(draw(optional(color=COLORS)))
        if draw(st.booleans()):
            entry["map"] = "lines.yaml"
    names = draw(st.lists(NAMES, max_size=3, unique=True))
    return {
        "world": {
            "properties": draw(
                optional(
                    velocity_iterations=st.integers(1, 30), position_iterations=st.integers(1, 30)
                )
            ),
            "layers": entries,
            "models": [
                {
                    "name": name,
                    "model": "robot.model.yaml",
                    **draw(optional(pose=POSES, namespace=NAMES)),
                }
                for name in names
            ],
        },
        "model": draw(models(layers)),
    }


def write(folder: Path, world: Any, model: Any) -> Path:
    (folder / "lines.yaml").write_text(
        "{type: line_segments, data: lines.dat, scale: 1, origin: [0, 0, 0]}"
    )
    (folder / "lines.dat").write_text("0 0 1 1\n")
    (folder / "robot.model.yaml").write_text(yaml.safe_dump(model))
    path = folder / "world.yaml"
    path.write_text(yaml.safe_dump(world))
    return path


@pytest.mark.slow
@bounded
@given(written=worlds())
def test_a_valid_world_is_read_as_it_was_written(files, written):
    world, model = written["world"], written["model"]

    path = write(files.folder, world, model)
    config = WorldConfig.from_file(path)
    World(config, loader=files.loader).close()

    for key in ("velocity_iterations", "position_iterations"):
        assert getattr(config, key) == world["properties"].get(key, 10)
    for layer, entry in zip(config.layers, world["layers"]):
        names = entry["name"] if isinstance(entry["name"], list) else [entry["name"]]
        assert list(layer.names) == names
        assert list(layer.color) == entry.get("color", [1, 1, 1, 1])
        assert len(config.walls_of(layer)) == ("map" in entry)
    assert len(config.layers) == len(world["layers"])
    assert len(config.models) == len(world["models"])
    for read, entry in zip(config.models, world["models"]):
        assert_read(read, entry, ["name"], {"namespace": "", "pose": [0, 0, 0]})
        assert_model(read.model, model)


BODY = {"pose": [0, 0, 0], "type": "dynamic", "color": [1, 1, 1, 0.5]}
BODY.update(linear_damping=0, angular_damping=0)
FOOTPRINT = {"friction": 0, "restitution": 0, "sensor": False, "collision": True}
FOOTPRINT["layers"] = ["all"]
JOINT = {"limits": None, "angle": 0, "frequency": 0, "damping": 0, "collide_connected": False}


def assert_read(config: Any, entry: Any, keys: Iterable[str], defaults: Dict[str, Any]) -> None:
    """Asserts that a configuration has the values of its entry, and defaults for others."""
    expected = {key: entry.get(key, value) for key, value in defaults.items()}
    expected.update((key, entry[key]) for key in keys)
    values = {key: getattr(config, key) for key in expected}
    assert {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()} == expected


def assert_model(config: Any, model: Any) -> None:
    """Asserts that the configuration of a model is that of its file."""
    for body, entry in zip(config.bodies, model["bodies"]):
        assert_read(body, entry, ["name"], BODY)
        assert len(body.footprints) == len(entry["footprints"])
        for footprint, shape in zip(body.footprints, entry["footprints"]):
            if isinstance(footprint.shape, Circle):
                assert_read(footprint.shape, shape, ["radius"], {"center": [0, 0]})
            else:
                assert [list(point) for point in footprint.shape.vertices] == shape["points"]
            assert_read(footprint, shape, ["density"], FOOTPRINT)
    joints = model.get("joints", [])
    assert len(config.joints) == len(joints)
    for joint, entry in zip(config.joints, joints):
        assert_read(joint, entry, ["type", "name"], JOINT)
        assert list(joint.bodies) == [end["name"] for end in entry["bodies"]]
        assert [list(anchor) for anchor in joint.anchors] == [e["anchor"] for e in entry["bodies"]]


# Invalid files

BYTES = st.one_of(st.integers(0, 255), st.sampled_from(list(b" \n\t:-[]{},'\"#&*!|>%@`?0.e$<")))

ODD = st.sampled_from(
    [None, True, False, 0, -1, 1, 2**40, -0.5, math.nan, math.inf, 1e300, 1e-300, "", "all", "text",
     "a b", "$eval 1 +", "$eval {1, 2, 3}", "$eval nil", "$include no.yaml", "$include world.yaml",
     "$[include] lines.yaml", [], {}, [1], [1, 2], [1, 2, 3], [0, 0, 0, 0], [[]], [{}], {"a": 1},
     {"name": "x"}, [[0, 0], [1, 0]], [[0, 0], [1, 0], [0, 1]], [[0, 0], [1, 1], [2, 2]], "\u2028",
     "x" * 300, "robot.model.yaml", "lines.dat", "/", "~", "..", {1: 2}, "dynamic", "circle"]
)  # fmt: skip


def places(node: Any, path: tuple = ()) -> List[tuple]:
    """The paths to all values in maps and lists."""
    items = node.items() if isinstance(node, dict) else enumerate(node)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, (dict, list)):
            found += places(value, (*path, key))
    return found


def mutate(draw: Any, document: Any) -> None:
    """Changes a random value or key of a document."""
    paths = places(document)
    if not paths:
        return
    path = draw(st.sampled_from(paths))
    parent = document
    for key in path[:-1]:
        parent = parent[key]
    key = path[-1]
    how = draw(st.sampled_from(["delete", "replace", "replace", "duplicate", "rename", "swap"]))
    if how == "delete":
        del parent[key]
    elif how == "replace":
        parent[key] = draw(ODD)
    elif how == "duplicate" and isinstance(parent, list):
        parent.append(copy.deepcopy(parent[key]))
    elif how == "rename" and isinstance(parent, dict):
        parent[draw(ODD.filter(lambda o: isinstance(o, (str, int))))] = parent.pop(key)
    else:
        other = draw(st.sampled_from(paths))
        value = document
        for step in other:
            value = value[step] if not isinstance(value, (str, type(None))) else value
        parent[key] = copy.deepcopy(value)


@st.composite
def spoilt_worlds(draw: Any) -> Dict[str, Any]:
    written = copy.deepcopy(draw(worlds()))
    if not written["world"]["models"]:
        written["world"]["models"] = [{"name": "robot", "model": "robot.model.yaml"}]
    for _ in range(draw(st.integers(1, 4))):
        mutate(draw, written[draw(st.sampled_from(["world", "model", "model"]))])
    return written


def assert_loads_or_is_refused(files) -> None:
    """Fails by any other exception than a FlatlandError."""
    with contextlib.suppress(FlatlandError):
        files.load().close()


@pytest.mark.slow
@settings(bounded, max_examples=40)
@given(written=spoilt_worlds())
def test_a_spoilt_world_loads_or_is_refused(files, written):
    write(files.folder, written["world"], written["model"])

    assert_loads_or_is_refused(files)


@pytest.mark.slow
@settings(bounded, max_examples=40)
@given(data=st.data())
@pytest.mark.parametrize("name", ["world.yaml", "robot.model.yaml", "map.yaml", "lines.dat"])
def test_a_garbled_file_loads_or_is_refused(good_files, name, data):
    good_files.write_good_ones()
    content = bytearray((good_files.folder / name).read_bytes())
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(content) - 1))
        how = data.draw(st.sampled_from(["set", "insert", "delete", "cut"]))
        if how == "set":
            content[at] = data.draw(BYTES)
        elif how == "insert":
            content[at:at] = bytes([data.draw(BYTES)]) * data.draw(st.integers(1, 3))
        elif how == "delete":
            del content[at : at + data.draw(st.integers(1, 20))]
        else:
            del content[at:]
        if not content:
            break
    (good_files.folder / name).write_bytes(content)

    assert_loads_or_is_refused(good_files)


@settings(bounded, max_examples=40)
@given(data=st.data())
def test_a_garbled_image_loads_or_is_refused(good_files, data):
    good_files.write_good_ones()
    path = good_files.folder / "map.png"
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 8))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)

    assert_loads_or_is_refused(good_files)
