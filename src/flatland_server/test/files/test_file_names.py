"""Names of files: in ROS packages, and in the folders where models are looked up."""

import sys

import pytest

from flatland2d.cli import main
from flatland_server.config.file_names import to_path
from flatland_server.exceptions import FlatlandError, ModelError
from flatland_server.geometry import Pose

MODEL = "bodies: [{name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}]\n"


@pytest.fixture
def package(good_files, monkeypatch):
    """A ROS package `robots`, which has the files of a world."""
    folder = good_files.folder / "workspace" / "robots"
    good_files.write(
        "workspace/robots/package.xml",
        "<package format='2'><name>robots</name><version>1.0.0</version>"
        "<description>x</description><maintainer email='a@b.c'>x</maintainer>"
        "<license>BSD</license></package>",
    )
    for name in ("map.yaml", "map.png", "lines.dat", "lines.yaml", "robot.model.yaml"):
        (good_files.folder / name).rename(folder / name)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(folder.parent))
    return folder


def test_all_files_of_a_world_may_be_in_a_package(good_files, package):
    good_files.edit("world.yaml", "map: map.yaml", "map: package://robots/map.yaml")
    good_files.edit("world.yaml", "map: lines.yaml", "map: package://robots/lines.yaml")
    good_files.edit("world.yaml", "model: robot", "model: package://robots/robot")
    map_file = "workspace/robots/map.yaml"
    good_files.edit(map_file, "image: map.png", "image: package://robots/map.png")
    good_files.edit("world.yaml", "properties: {", "properties: $include package://robots/p.yaml #")
    (package / "p.yaml").write_text("{velocity_iterations: 7}")

    world = good_files.load()

    assert len(world.get_layer("map").segments) > 4
    assert world.get_model("robot").config.path == package / "robot.model.yaml"
    world.spawn_model("package://robots/robot.model.yaml", "second", "second", Pose())
    good_files.edit("world.yaml", "package://robots/p.yaml", "package://robts/p.yaml")
    assert 'world.yaml:1: no ROS package is named "robts"' in good_files.refusal()


def test_a_path_may_begin_with_the_home_folder(good_files, monkeypatch):
    monkeypatch.setenv("HOME", str(good_files.folder / "home"))
    for name in ("map.yaml", "map.png", "robot.model.yaml"):
        good_files.write(f"home/{name}", (good_files.folder / name).read_bytes())
    good_files.edit("world.yaml", "map: map.yaml", "map: ~/map.yaml")
    good_files.edit("world.yaml", "model: robot", "model: ~/robot")

    world = good_files.load()
    world.spawn_model("~/robot.model.yaml", "another", "another", Pose())

    folders = {model.config.path.parent.name for model in world.models.values()}
    assert folders == {"home"}
    with pytest.raises(ModelError, match=r"there is no file /.*/home/none\.yaml$"):
        world.spawn_model("~/none.yaml", "none", "", Pose())


def test_flatland_check_takes_a_package(package, capsys):
    (package / "box.yaml").write_text(MODEL)

    assert main(["check", "package://robots/box.yaml"]) == 0
    assert main(["check", "package://robts/box.yaml"]) == 1

    assert 'no ROS package is named "robts" (did you mean "robots"?)' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("package://robts/a.yaml", 'no ROS package is named "robts" (did you mean "robots"?)'),
        ("package://robots", 'expected package://name/path, found "package://robots"'),
        ("package:///a.yaml", 'expected package://name/path, found "package:///a.yaml"'),
        ("package://robots/none.yaml", "expected a file, but workspace/robots/none.yaml is not"),
    ],
)
def test_a_file_missing_in_a_package_is_named_with_its_line(good_files, package, name, message):
    good_files.edit("world.yaml", "model: robot.model.yaml", f"model: {name}")

    assert f"world.yaml:13: models[0].model: {message}" in good_files.refusal()


# Packages without ROS


class PythonPackage:
    """A Python package `loader_robots` in the library folder of a prefix."""

    def __init__(self, prefix):
        self.share = prefix / "share" / "loader_robots"
        self.folder = prefix / "lib" / "python3" / "site-packages" / "loader_robots"
        self.write(self.folder / "__init__.py")

    @staticmethod
    def write(file, text=""):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)


@pytest.fixture
def python_package(tmp_path, monkeypatch):
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    package = PythonPackage(tmp_path / "prefix")
    monkeypatch.syspath_prepend(str(package.folder.parent))
    return package


def test_without_ros_a_package_is_an_installed_python_package(python_package):
    python_package.write(python_package.folder / "worlds" / "a.yaml")
    python_package.write(python_package.share / "worlds" / "a.yaml")
    python_package.write(python_package.share / "worlds" / "b.yaml")

    paths = [to_path(f"package://loader_robots/worlds/{name}.yaml") for name in "abc"]

    assert paths == [
        python_package.folder / "worlds" / "a.yaml",  # first the files of the package itself
        python_package.share / "worlds" / "b.yaml",
        python_package.folder / "worlds" / "c.yaml",  # for the error of a missing file
    ]
    assert "loader_robots" not in sys.modules


@pytest.mark.parametrize("layout", ["src/loader_robots", "loader_robots"])
def test_the_source_of_an_editable_package_has_its_files(tmp_path, monkeypatch, layout):
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/nothing")
    PythonPackage.write(tmp_path / layout / "__init__.py")
    PythonPackage.write(tmp_path / "package.xml", "<package><name>loader_robots</name></package>")
    PythonPackage.write(tmp_path / "worlds" / "a.yaml")
    monkeypatch.syspath_prepend(str((tmp_path / layout).parent))

    assert to_path("package://loader_robots/worlds/a.yaml") == tmp_path / "worlds" / "a.yaml"


def test_a_ros_package_hides_the_python_package_of_its_name(python_package, tmp_path, monkeypatch):
    ros = tmp_path / "workspace" / "of_another_name"
    python_package.write(ros / "package.xml", "<package><name>loader_robots</name></package>")
    python_package.write(python_package.folder / "a.yaml")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nothing:{ros.parent}")

    assert to_path("package://loader_robots/a.yaml") == ros / "a.yaml"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("loader_robot", ' (did you mean "loader_robots"?)'),
        ("loader.robots", ' (did you mean "loader_robots"?)'),
        ("loader_namespace", ""),
        ("..", ""),
        ("os", ""),  # a module, which has no folder
    ],
)
def test_without_ros_the_error_speaks_of_pip(python_package, tmp_path, monkeypatch, name, hint):
    PythonPackage.write(tmp_path / "loader_namespace" / "a.yaml")  # not a package: a folder
    monkeypatch.syspath_prepend(str(tmp_path))

    with pytest.raises(FlatlandError) as error:
        to_path(f"package://{name}/a.yaml")

    assert str(error.value) == (
        f'no Python package is named "{name}"{hint}; is it installed (pip install)?'
    )


# The folders of models


@pytest.fixture
def fleet(files):
    """Folders of models besides the world's, and a world that may name them."""
    (files.folder / "world").mkdir()
    for name in ("one/a.yaml", "two/a.yaml", "two/b.yaml", "world/c.yaml", "two/sub/d.yaml"):
        files.write(name, MODEL)
    return files


def load(fleet, *models: str):
    entries = "".join(f"- {{name: m{i}, model: {name}}}\n" for i, name in enumerate(models))
    fleet.write("world/world.yaml", f"properties: {{}}\nlayers: []\nmodels:\n{entries or '  []'}")
    folders = [fleet.folder / "one", fleet.folder / "two"]
    return fleet.load("world/world.yaml", model_folders=folders)


def paths(fleet, world) -> list:
    return [str(m.config.path.relative_to(fleet.folder)) for m in world.models.values()]


def test_a_model_is_looked_up_beside_the_world_then_in_folders(fleet):
    world = load(fleet, "a.yaml", "b.yaml", "c.yaml", "sub/d.yaml")

    assert paths(fleet, world) == ["one/a.yaml", "two/b.yaml", "world/c.yaml", "two/sub/d.yaml"]


def test_a_spawned_model_is_looked_up_there_too(fleet, monkeypatch):
    world = load(fleet)
    monkeypatch.chdir(fleet.folder / "one")

    for name in ("c.yaml", "b.yaml"):
        world.spawn_model(name, name[0], "", Pose())

    assert paths(fleet, world) == ["world/c.yaml", "two/b.yaml"]


@pytest.mark.parametrize("name", ["./b.yaml", "../b.yaml"])
def test_a_name_that_says_where_it_is_is_not_looked_up(fleet, name):
    with pytest.raises(FlatlandError, match=r"is not there$"):
        load(fleet, name)
    with pytest.raises(ModelError, match=r"there is no file .+/b\.yaml$"):
        load(fleet).spawn_model(name, "b", "", Pose())


def test_a_model_that_is_nowhere_is_an_error_with_the_folders(fleet, monkeypatch):
    monkeypatch.chdir(fleet.folder / "two")
    with pytest.raises(FlatlandError) as of_world:
        load(fleet, "e.yaml")
    with pytest.raises(ModelError) as of_spawn:
        load(fleet).spawn_model("e.yaml", "e", "", Pose())

    assert fleet.without_folder(str(of_world.value)) == (
        "world/world.yaml:4: models[0].model: expected a file, but world/e.yaml is not there, "
        "nor in one, two"
    )
    assert fleet.without_folder(str(of_spawn.value)) == (
        "there is no file two/e.yaml, nor in world, one, two"
    )


def test_flatland_check_looks_in_folders_of_models(fleet, monkeypatch):
    load(fleet, "b.yaml")
    path = str(fleet.folder / "world" / "world.yaml")

    assert main(["check", path]) == 1
    assert main(["check", path, "--models", str(fleet.folder / "two")]) == 0
