"""The architecture, enforced: which folder may import which, and where rospy is allowed."""

import ast
import os
import re
from functools import lru_cache
from pathlib import Path
from typing import Callable, Dict, Iterable, Iterator, List, Set, Tuple

import pytest
from without_ros import run_without_ros

SRC = Path(__file__).resolve().parents[3]
ROOMS = SRC / "flatland_server" / "src" / "core"
ROSPY = ("rospy", "rosgraph", "roslaunch", "tf2_ros", "flatland_server.ros")

LAYERS = (  # each may import those before it
    "",  # modules at the top: exceptions, geometry, ...
    "config",
    "maps",
    "models",
    "messages",
    "transport",
    "plugins",
    "simulation",
    "hub",
    "testing",
    "ros.rospy_patches",
    "ros",
    "flatland2d.rendering",
    "flatland2d",  # Simulation and the objects that it returns
    "flatland2d.batch",
    "flatland2d.sweep",
    "flatland2d.cli",
)
"""Folders of flatland_server, then those of flatland2d."""
CORE = ("flatland_server", "flatland2d")
CORE_MODULES = ("flatland_server._core", "flatland_server._box2d_rays")
FRONTS = ("flatland_server/__init__.py", "flatland2d/__init__.py", "flatland2d/__main__.py")
"""The files that users start from: above all folders."""

CLIENTS = (
    "flatland2d",
    "flatland_bridge",
    "flatland_gym",
    "flatland_navigation",
    "flatland_plugins",
    "flatland_viz",
)
"""Packages that import flatland_server through its fronts: packages and modules at the top."""
OTHERS = ("flatland_benchmark", "flatland_gym", "flatland_plugins", "flatland_viz")

IMPORT_MODULES = """
import importlib

for name in sys.argv[1:]:
    importlib.import_module(name)
"""


def sources(package: str) -> List[Path]:
    """The Python files of a package."""
    return sorted((SRC / package / "src" / package).rglob("*.py"))


def module_name(path: Path) -> str:
    """The name under which a file is imported."""
    words = path.with_suffix("").parts[len(SRC.parts) + 2 :]
    return ".".join(words[:-1] if words[-1] == "__init__" else words)


def is_ros_module(path: Path) -> bool:
    """True if a file belongs to flatland_server.ros."""
    return f"{module_name(path)}.".startswith("flatland_server.ros.")


@lru_cache(maxsize=None)
def parsed(path: Path) -> List[ast.AST]:
    """All nodes of a file's syntax tree."""
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def imports(path: Path) -> Iterator[Tuple[int, str]]:
    """The line and the target of each import in a file, those for type checkers included."""
    for node in parsed(path):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: a relative import"
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


def found(paths: Iterable[Path], is_sought: Callable[[str], bool]) -> List[str]:
    """The imports in these files that are sought."""
    return [
        f"{path.relative_to(SRC)}:{line}: imports {name}"
        for path in paths
        for line, name in imports(path)
        if is_sought(name)
    ]


def forbidden_imports(paths: Iterable[Path], forbidden: Tuple[str, ...]) -> List[str]:
    """The imports of forbidden packages in these files."""
    words = tuple(f"{word}." for word in forbidden)
    return found(paths, lambda name: f"{name}.".startswith(words))


def core_sources() -> List[Path]:
    """The Python files of the two packages that have layers."""
    return [path for package in CORE for path in sources(package)]


def ros_free_sources() -> List[Path]:
    """The files of core and plugins that need no ROS."""
    plugins = [*sources("flatland_plugins"), *sources("flatland_example_plugins")]
    return [path for path in core_sources() if not is_ros_module(path)] + plugins


def folder_of(module: str) -> str:
    """The layer that a module or a name in it belongs to."""
    rest = f"{module}.".replace("flatland_server.", "", 1)
    folders = [folder for folder in LAYERS if folder and rest.startswith(f"{folder}.")]
    return max(folders, key=len, default="")


def folder_imports() -> Dict[str, Set[str]]:
    """The other layers that each layer imports."""
    found: Dict[str, Set[str]] = {}
    for path in core_sources():
        if str(path).endswith(FRONTS):
            continue
        folder = folder_of(module_name(path))
        names = [name for _, name in imports(path) if name.partition(".")[0] in CORE]
        found.setdefault(folder, set()).update({folder_of(name) for name in names} - {folder})
    return found


def test_clients_import_the_server_through_its_fronts():
    server = SRC / "flatland_server" / "src"
    inside = [
        f"{path.relative_to(SRC)}:{node.lineno}: imports {node.module}"
        for package in CLIENTS
        for path in sources(package)
        for node in parsed(path)
        if isinstance(node, ast.ImportFrom)
        and str(node.module).count(".") > 1
        and server.joinpath(*str(node.module).split(".")).with_suffix(".py").exists()
    ]

    assert inside == []


def test_ros_free_modules_need_no_ros():
    modules = [module_name(path) for path in ros_free_sources()]

    run_without_ros(IMPORT_MODULES, *modules)

    assert len(modules) > 25


def test_rospy_is_really_blocked():
    with pytest.raises(pytest.fail.Exception, match="rospy is blocked"):
        run_without_ros(IMPORT_MODULES, "flatland_server.ros.server")


def test_plugins_import_from_the_front_alone():
    is_inside = re.compile(r"flatland_server\.\w+\.").match
    plugins = [*sources("flatland_plugins"), *sources("flatland_example_plugins")]

    assert found(plugins, lambda name: bool(is_inside(name))) == []


def test_messages_are_asked_for_by_name():
    is_message = lambda name: name.partition(".")[0].endswith(("_msgs", "genpy"))  # noqa: E731

    assert found(ros_free_sources(), is_message) == []
    assert found(filter(is_ros_module, sources("flatland_server")), is_message) != []


@pytest.mark.parametrize(
    ("package", "forbidden"),
    [
        ("flatland_server", ("flatland2d", *OTHERS)),
        ("flatland2d", (*OTHERS, *ROSPY)),
        ("flatland_bridge", ("flatland_benchmark", "flatland_gym", "flatland_viz")),
        ("flatland_plugins", ("flatland2d", "flatland_benchmark", "flatland_viz", *ROSPY)),
        ("flatland_navigation", ("flatland2d", "flatland_benchmark", "flatland_gym")),
        ("flatland_teleop", ("flatland2d", "flatland_server")),
        (
            "flatland_viz",
            ("flatland2d", "flatland_benchmark", "flatland_plugins", "flatland_server"),
        ),
        ("flatland_gym", ("flatland_benchmark", "flatland_plugins", "flatland_viz", *ROSPY)),
    ],
)
def test_packages_import_one_way(package, forbidden):
    assert forbidden_imports(sources(package), forbidden) == []


def test_only_a_running_flatland_serve_imports_the_bridge():
    packages = [path.name for path in SRC.glob("flatland*") if path.name != "flatland_bridge"]
    paths = [path for package in packages for path in sources(package)]
    importing = forbidden_imports(
        paths, ("flatland_bridge", "websockets", "orjson", "cbor2", "rclpy")
    )

    assert {line.partition(":")[0] for line in importing} == {
        "flatland2d/src/flatland2d/cli/serve.py"
    }
    run_without_ros("import flatland2d.cli\nassert 'flatland_bridge' not in sys.modules")


def test_only_the_node_of_the_bridge_imports_rospy():
    importing = forbidden_imports(sources("flatland_bridge"), ROSPY)

    assert {line.partition(":")[0].rpartition("/")[2] for line in importing} == {
        *("bridge_node.py", "ros_graph.py", "ros_services.py")
    }


def test_every_folder_has_a_place_in_the_order():
    folders = {path.parent for path in core_sources()}
    names = {".".join(f.parts[len(SRC.parts) + 2 :]) for f in folders}
    names = {f"{name}.".replace("flatland_server.", "", 1).rstrip(".") for name in names}

    assert names == set(LAYERS)


def test_folders_import_one_way():
    upward = {
        f"{folder or 'top'} imports {target or 'top'}"
        for folder, targets in folder_imports().items()
        for target in targets
        if LAYERS.index(target) > LAYERS.index(folder)
    }

    assert upward == {"flatland2d imports flatland2d.batch"}  # by Simulation.branch, when called


def test_nothing_within_imports_the_public_front():
    within = [path for path in core_sources() if not str(path).endswith(FRONTS)]
    modules = {*map(module_name, core_sources()), *CORE_MODULES}

    def is_front(name: str) -> bool:
        return name.partition(".")[0] in CORE and name.count(".") == 1 and name not in modules

    assert found(within, is_front) == []


def test_only_the_folder_ros_imports_rospy():
    outside = [path for path in core_sources() if not is_ros_module(path)]
    inside = [path for path in sources("flatland_server") if is_ros_module(path)]

    assert forbidden_imports(outside, ROSPY) == []
    assert forbidden_imports(inside, ("rospy",)) != []


# The rooms of the core use each other as their READMEs say.


def allowed(room: str) -> Set[str]:
    """The room, and those that its README names as used."""
    [uses] = re.findall(r"^Uses: ([^.]*)", (ROOMS / room / "README.md").read_text(), re.MULTILINE)
    return {room, *re.findall(r"`(\w+)`", uses)}


@pytest.mark.parametrize("room", sorted(path.parent.name for path in ROOMS.glob("*/README.md")))
def test_a_room_includes_only_rooms_named_in_its_readme(room):
    for path in sorted((ROOMS / room).glob("*.[ch]pp")):
        text = path.read_text()
        assert set(re.findall(r'#include "(\w+)/', text)) <= allowed(room), path.name
        assert room == "bindings" or not re.search(r"pybind11|Python\.h", text), path.name


def test_no_node_has_the_executable_bit():
    """Rosrun would find it besides catkin's relay, and ask which one is meant in some folders."""
    nodes = sorted(SRC.glob("*/nodes/*"))

    assert nodes
    assert [node for node in nodes if os.access(node, os.X_OK)] == []
