"""The library as pip installs it: in a virtual environment without ROS."""

import json
import os
import re
import shutil
import signal
import subprocess
import urllib.request
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import page_run
import pip_environments
import pytest
from blocks import blocks_of, needs_of

ROOT = Path(__file__).resolve().parents[4]
EXAMPLE = ROOT / "src" / "flatland_example_plugins"
DRIVE_THE_OFFICE = Path(__file__).with_name("drive_the_office.py")

pytestmark = pytest.mark.slow

IMPORT_ALL = """
import importlib, pkgutil, sys
import flatland2d, flatland_navigation, flatland_plugins, flatland_server
for package in (flatland2d, flatland_navigation, flatland_server, flatland_plugins):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if module.name.endswith("__main__"):
            continue
        try:
            importlib.import_module(module.name)
        except flatland2d.FlatlandError as error:
            assert "pip install '.[" in str(error), error  # it needs an extra
ros = ("genpy", "genmsg", "rospy", "rosgraph", "roslib", "roslaunch", "rospkg", "catkin_pkg")
found = {name.partition(".")[0] for name in sys.modules}
print(sorted(name for name in found if name in ros or name.endswith("_msgs")))
"""

LOAD_PLUGINS = """
import sys
from flatland_server import ModelPlugin, PluginLoader, WorldPlugin
bases = {"ModelPlugin": ModelPlugin, "WorldPlugin": WorldPlugin}
for name, base in zip(sys.argv[1::2], sys.argv[2::2]):
    found = PluginLoader().load(name, bases[base])
    print(f"{found.__module__}.{found.__name__}")
"""

RUN_THE_CONVEYOR = """
from flatland2d import Simulation
path = "package://my_plugins/worlds/conveyor/world.yaml"
with Simulation(path, step_size=0.01, topics=["/gate/contacts"]) as sim:
    sim.step(3000)
    print(sim.last("/gate/contacts").data > 0)
"""


EVALUATE_AND_TRAIN = """
import sys, flatland2d, flatland_gym
print(flatland2d.Simulation(sys.argv[1]).models)
try:
    flatland_gym.NavigationEnv
except Exception as error:
    print(error)
"""


def declared(xml):
    """Name, base and class path of each plugin in an XML file."""
    classes = [each.attrib for each in ElementTree.parse(xml).iter("class")]
    return [(c["name"], c["base_class_type"].rpartition(".")[2], c["type"]) for c in classes]


BUILT_IN = declared(ROOT / "src" / "flatland_plugins" / "flatland_plugins.xml")


def test_the_entry_points_equal_the_plugins_of_the_ros_package(wheel):
    with zipfile.ZipFile(wheel) as archive:
        [name] = [name for name in archive.namelist() if name.endswith("entry_points.txt")]
        lines = archive.read(name).decode().partition("[flatland_server.plugins]\n")[2]
    entry_points = [line for line in lines.partition("\n[")[0].splitlines() if line]

    assert sorted(entry_points) == sorted(
        f"{name} = {':'.join(path.rsplit('.', 1))}" for name, _, path in BUILT_IN
    )


def test_the_wheel_has_packages_worlds_and_definitions_only(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()

    ours = {
        f"flatland_{each}"
        for each in ["bridge", "gym", "navigation", "plugins", "server", "teleop"]
    }
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {"flatland2d", *ours}
    assert not [name for name in names if "__pycache__" in name or "/test/" in name]
    server = {name.partition("/")[2] for name in names if name.startswith("flatland_server/")}
    assert {"py.typed", "_core.pyi", "worlds/office/office.png"} <= server
    assert not [name for name in server if name.startswith("ros/")]  # the node's
    packages = {name.partition("/")[0] for name in names if name.endswith("/__init__.py")}
    assert {f"{package}/py.typed" for package in packages} <= set(names)
    assert {"flatland_gym/worlds/discs.yaml", "flatland_gym/policies/discs.npz"} <= set(names)


def test_the_script_of_the_guide_drives_and_scans(library):
    guide = (ROOT / "docs" / "quick_start.md").read_text()
    [script] = re.findall(r"^```python\n(.*?)^```", guide, re.DOTALL | re.MULTILINE)

    assert re.search(r"^2\.0 s, 1081 beams, the nearest \d", library.run("-c", script))


def test_no_module_needs_ros(library):
    assert library.run("-c", IMPORT_ALL).strip() == "[]"


def test_the_page_is_viewed_with_what_the_library_itself_needs(library):
    process = library.start("-m", "flatland2d", "view", "office", BROWSER="true")
    try:
        url = re.fullmatch(r"page: (.*/)\?token=.*\n", process.stdout.readline())[1]
        page = urllib.request.urlopen(url).read().decode()
        for file in re.findall(r'(?:src|href)="(\w+\.\w+)"', page):
            assert urllib.request.urlopen(url + file).status == 200
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
    finally:
        process.kill()


def test_the_plugins_are_found(library):
    words = [word for name, base, _ in BUILT_IN for word in (name, base)]

    assert library.run("-c", LOAD_PLUGINS, *words).split() == [path for _, _, path in BUILT_IN]


def test_the_office_is_the_same_to_the_bit_as_by_catkin(library):
    under_pip = json.loads(library.run(DRIVE_THE_OFFICE))
    output = subprocess.check_output(["/usr/bin/python3", DRIVE_THE_OFFICE], text=True)
    under_catkin = json.loads(output)

    assert under_pip.pop("core").startswith(f"{library.folder}/")
    assert under_catkin.pop("core").startswith(f"{ROOT}/devel/")
    assert under_pip == under_catkin


def test_box2d_from_source_gives_the_same_bits_in_the_office(library, builder, tmp_path):
    source = os.environ.get("FLATLAND_BOX2D_SOURCE")
    if not source:
        pytest.skip("FLATLAND_BOX2D_SOURCE names no folder with the source of Box2D 2.4.1")
    pip_environments.copy_sources(tmp_path)
    defines = ("FLATLAND_BOX2D=source", f"FETCHCONTENT_SOURCE_DIR_BOX2D={source}")
    settings = [f"cmake.define.{each}" for each in defines]
    wheel = builder.wheel(tmp_path / "wheel", tmp_path, *settings)
    library.pip("install", "--no-deps", "--no-index", f"--target={tmp_path / 'source'}", wheel)

    from_source = json.loads(library.run(DRIVE_THE_OFFICE, PYTHONPATH=tmp_path / "source"))
    of_system = json.loads(library.run(DRIVE_THE_OFFICE))

    core = from_source.pop("core")
    assert core.startswith(f"{tmp_path}/")
    assert "box2d" not in subprocess.check_output(["ldd", core], text=True)
    assert "box2d" in subprocess.check_output(["ldd", of_system.pop("core")], text=True)
    assert from_source == of_system


def test_pip_installs_a_ros_plugin_package_unchanged(library, builder, tmp_path):
    """A copy of the example package, renamed as its README says."""
    copy = tmp_path / "my_plugins"
    shutil.copytree(EXAMPLE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "src" / EXAMPLE.name).rename(copy / "src" / copy.name)
    for file in copy.rglob("*"):
        if file.is_file():
            file.write_text(file.read_text().replace(EXAMPLE.name, copy.name))
    plugins = declared(copy / "flatland_plugins.xml")
    target = tmp_path / "target"

    builder.pip(
        "install", "--no-build-isolation", "--no-deps", "--no-index", f"--target={target}", copy
    )
    words = [word for name, base, _ in plugins for word in (f"my_plugins::{name}", base)]
    output = library.run("-c", LOAD_PLUGINS + RUN_THE_CONVEYOR, *words, PYTHONPATH=target)

    *loaded, has_counted = output.splitlines()
    assert loaded[: len(plugins)] == [path for _, _, path in plugins]
    assert has_counted == "True"


def test_expressions_work_and_environments_name_their_extra(library, tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text(
        "properties: {}\nlayers: []\nmodels:\n- name: $eval string.rep('a', 3)\n"
        "  model: {bodies: [{name: b, footprints: []}]}\n"
    )

    models, message = library.run("-c", EVALUATE_AND_TRAIN, world).splitlines()

    assert models == "{aaa}"
    assert message == "NavigationEnv needs Gymnasium: pip install '.[gym]' in Flatland's clone"


def test_the_command_tells_the_version_of_the_wheel(library, wheel):
    assert library.command("flatland", "--version") == f"flatland {wheel.name.split('-')[1]}\n"


# Requirements of pages and examples

PAGES = [
    page
    for page in sorted((ROOT / "docs").rglob("*.md"))
    if blocks_of(page) and getattr(needs_of(page), "pip", False)
]
EXAMPLES = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
VIEWED = EXAMPLES.partition("shows the worlds of ")[2].partition(", and the")[0].replace(" and", "")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT / "docs")))
def test_a_page_that_pip_is_enough_for_does_what_it_says(page, reader, tmp_path):
    reader.run(tmp_path, page_run.__file__, page, tmp_path)


@pytest.mark.parametrize("number", [1, 21, 41], ids=["gaps", "planner", "trained"])
def test_each_controller_of_the_example_sweep_runs(number, reader, tmp_path):
    scenarios = ROOT / "examples" / "sweep" / "scenarios.yaml"
    words = ["sweep", scenarios, "--replay", number, "--out", tmp_path]

    assert "outcome: goal" in reader.run(tmp_path, reader.command, *words)


@pytest.mark.parametrize("name", re.findall(r"\w+", VIEWED))
def test_the_world_of_an_example_that_can_be_viewed_runs(name, reader, tmp_path):
    world = ROOT / "examples" / name / "world.yaml"

    reader.run(tmp_path, reader.command, "run", world, "--seconds", 0.1)
