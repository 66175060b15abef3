"""The one-way street: who may import whom, and that no ROS-free module needs rospy."""

import ast
import subprocess
import sys
from pathlib import Path
from typing import Iterator, List, Tuple

import pytest

SRC = Path(__file__).resolve().parents[3]
ROSPY = ("rospy", "rosgraph", "roslaunch", "tf2_ros", "flatland_server.ros")

IMPORT_WITHOUT_ROSPY = """
import importlib
import sys

class Wall:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("rospy", "rosgraph", "roslaunch"):
            raise ModuleNotFoundError(f"{name} is blocked")

sys.meta_path.insert(0, Wall())
for name in sys.argv[1:]:
    importlib.import_module(name)
"""


def sources(package: str) -> List[Path]:
    """The Python files of a package."""
    return sorted((SRC / package / "src" / package).rglob("*.py"))


def module_name(path: Path) -> str:
    """What a file is called when it is imported."""
    words = path.with_suffix("").parts[len(SRC.parts) + 2 :]
    return ".".join(words[:-1] if words[-1] == "__init__" else words)


def is_at_the_ros_edge(path: Path) -> bool:
    """Whether a file belongs to flatland_server.ros."""
    return module_name(path).startswith("flatland_server.ros")


def imports(path: Path) -> Iterator[Tuple[int, str]]:
    """The lines of a file's imports, wherever they stand, with what is imported."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: a relative import"
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


def trespasses(paths: List[Path], forbidden: Tuple[str, ...]) -> List[str]:
    """The imports, in these files, of packages that they must not know."""
    return [
        f"{path.relative_to(SRC)}:{line}: imports {name}"
        for path in paths
        for line, name in imports(path)
        if any(f"{name}.".startswith(f"{word}.") for word in forbidden)
    ]


def import_without_rospy(modules: List[str]) -> "subprocess.CompletedProcess[str]":
    """Imports modules in a Python in which there is no rospy."""
    return subprocess.run(
        [sys.executable, "-c", IMPORT_WITHOUT_ROSPY, *modules], stderr=subprocess.PIPE, text=True
    )


def test_ros_free_modules_need_no_rospy():
    paths = [p for p in sources("flatland_server") if not is_at_the_ros_edge(p)]
    modules = [module_name(path) for path in [*paths, *sources("flatland_plugins")]]

    result = import_without_rospy(modules)

    assert len(modules) > 25
    assert result.returncode == 0, result.stderr


def test_the_blockade_is_real():
    result = import_without_rospy(["flatland_server.ros.server"])

    assert "rospy is blocked" in result.stderr


@pytest.mark.parametrize(
    ("package", "forbidden"),
    [
        ("flatland_server", ("flatland_benchmark", "flatland_plugins", "flatland_viz")),
        ("flatland_plugins", ("flatland_benchmark", "flatland_viz", *ROSPY)),
        ("flatland_viz", ("flatland_benchmark", "flatland_plugins", "flatland_server")),
    ],
)
def test_imports_go_one_way(package, forbidden):
    assert trespasses(sources(package), forbidden) == []


def test_only_the_ros_edge_imports_rospy():
    inside = [path for path in sources("flatland_server") if not is_at_the_ros_edge(path)]
    edge = [path for path in sources("flatland_server") if is_at_the_ros_edge(path)]

    assert trespasses(inside, ROSPY) == []
    assert trespasses(edge, ("rospy",)) != []
