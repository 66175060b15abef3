"""The packages of this clone as ROS's tools see them: found once, in order, with all they need."""

import ast
import os
import subprocess
from pathlib import Path

import pytest
import rospkg
from catkin_pkg.packages import find_packages
from catkin_pkg.topological_order import topological_order

ROOT = Path(__file__).resolve().parents[4]
PACKAGES = {package.name: package for package in find_packages(str(ROOT)).values()}
PYTHON_PACKAGES = sorted(name for name in PACKAGES if (ROOT / "src" / name / "setup.py").exists())


def rospack(*arguments):
    """The output of rospack about this clone and the system's packages."""
    return subprocess.run(
        ["rospack", *arguments],
        env={**os.environ, "ROS_PACKAGE_PATH": f"{ROOT}:/usr/share"},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout.splitlines()


def run_depends(name):
    return {depend.name for depend in PACKAGES[name].exec_depends}


def imported(folder):
    """The top-level modules that the Python files of a folder import."""
    names = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names.update(alias.name.partition(".")[0] for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                names.add(node.module.partition(".")[0])
    return names


def test_each_package_is_found_once_in_its_place():
    """Also if build/, devel/ or an install space in the clone have copies."""
    found = [line.split(" ", 1) for line in rospack("list")]

    ours = sorted((name, path) for name, path in found if path.startswith(f"{ROOT}/"))
    expected = sorted(PACKAGES.keys() - {"flatland"})  # rospack lists no metapackages
    places = {"flatland_examples": "examples"}
    assert ours == [(name, f"{ROOT}/{places.get(name, f'src/{name}')}") for name in expected]
    assert not PACKAGES.keys() & set(rospack("list-duplicates"))


def test_catkin_can_order_them():
    order = [package.name if path else package for path, package in topological_order(str(ROOT))]

    assert sorted(order) == sorted(PACKAGES)
    assert order.index("flatland_msgs") < order.index("flatland_viz")


@pytest.mark.parametrize("name", sorted(PACKAGES.keys() - {"flatland"}))
def test_no_package_depends_on_itself_by_way_of_others(name):
    """Rospack gives up on circles, of run dependencies too."""
    assert name not in rospack("depends", name)


@pytest.mark.parametrize("name", PYTHON_PACKAGES)
def test_a_manifest_names_the_ros_packages_that_are_imported(name):
    known = set(rospkg.RosPack().list()) | PACKAGES.keys()
    optional = {"flatland_bridge"} if name == "flatland2d" else set()  # for `flatland serve`

    assert imported(ROOT / "src" / name / "src") & known - {name} - optional <= run_depends(name)


def test_the_metapackage_brings_all_but_the_example():
    assert run_depends("flatland") == PACKAGES.keys() - {"flatland", "flatland_example_plugins"}
