"""The node's parameters: their defaults, and what is refused."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import rospy
import yaml
from rospkg import RosPack

from flatland_server.exceptions import FlatlandError
from flatland_server.ros.server_parameters import read_config


@pytest.fixture
def read(monkeypatch):
    """Reads the configuration of a node /robots/server with these private parameters, besides a
    world's path, and others by their absolute names.
    """

    def full(name):
        return name.replace("~", "/robots/server/")

    def read_with(others=None, **params):
        private = {full(f"~{k}"): v for k, v in {"world_path": "/world.yaml", **params}.items()}
        params = {k: v for k, v in {**private, **(others or {})}.items() if v is not None}

        def search(name):  # as the ROS master does
            namespaces = ("/robots/server/", "/robots/", "/")
            return next((ns + name for ns in namespaces if ns + name in params), None)

        for name, fake in (
            ("get_param", lambda name, default: params.get(full(name), default)),
            ("search_param", search),
            ("resolve_name", full),
            ("get_param_names", lambda: list(params)),
            ("delete_param", lambda name: params.pop(full(name))),
        ):
            monkeypatch.setattr(rospy, name, fake)
        return read_config().server

    return read_with


def test_the_defaults_are_those_of_the_launch_file(read):
    launch = ElementTree.parse(Path(RosPack().get_path("flatland_server"), "launch/server.launch"))
    defaults = {
        each.get("name"): yaml.safe_load(each.get("default"))
        for each in launch.iter("arg")
        if not each.get("default", "$").startswith("$")
    }
    del defaults["use_rviz"]  # is for the launch file alone

    assert len(defaults) > 15
    assert read(**defaults) == read()


def test_a_history_is_kept_with_the_window_by_default(read):
    assert not read(show_viz=False).history
    assert read(show_viz=False, history=True).history
    assert not read(history=False).history


def test_parameters_of_outer_namespaces_are_the_fallback(read, caplog):
    caplog.set_level("INFO", "rosout")
    others = {"/world_path": "/a.yaml", "/step_size": 0.1, "/robots/step_size": 0.01, "/seed": 3}

    config = read(others, world_path=None, seed=5)

    assert (config.world_path, config.step_size, config.seed) == (Path("/a.yaml"), 0.01, 5)
    assert "~world_path is not set: /world_path is used" in caplog.text
    assert "~step_size is not set: /robots/step_size is used" in caplog.text
    assert "seed" not in caplog.text


def test_a_blank_of_a_launch_file_is_no_value(read):
    assert read(train_mode=" ", control_period=" ") == read()
    config = read({"/train_mode": True}, train_mode=" ")
    assert config.train_mode
    assert read(models=" ", initial_pose=" ").models == ()


def test_a_world_that_is_set_for_another_node_is_named(read):
    with pytest.raises(FlatlandError, match="; others are set: /server/world_path"):
        read({"/server/world_path": "/a.yaml"}, world_path=None)


@pytest.mark.parametrize("separate", [":".join, list])
def test_folders_of_models_are_a_list_or_separated_by_colons(read, tmp_path, separate):
    folder = Path(RosPack().get_path("flatland_server"))
    names = [str(tmp_path), "package://flatland_server/worlds", "/"]

    assert read(models=separate(names)).models == (tmp_path, folder / "worlds", Path("/"))


def test_the_world_may_be_in_a_package(read):
    path = read(world_path="package://flatland_server/worlds/office/world.yaml").world_path

    assert path.is_file()
    assert path.parts[-2:] == ("office", "world.yaml")


def test_a_relative_world_path_begins_in_the_working_directory(read, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FlatlandError) as refusal:
        read(world_path="sub/world.yaml")
    assert str(refusal.value) == (
        f"~world_path: there is no file {tmp_path}/sub/world.yaml; a relative path begins in the "
        "node's working directory, which is not that of roslaunch: write "
        '"$PWD/sub/world.yaml" for it'
    )

    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "world.yaml").touch()

    assert read(world_path="sub/world.yaml").world_path == tmp_path / "sub" / "world.yaml"


def test_the_world_may_run_as_fast_as_the_machine_can(read):
    assert read(update_rate="inf").update_rate == float("inf")


@pytest.mark.parametrize("settings", [{}, {"update_rate": 333.3333333, "step_size": 0.003}])
def test_stamps_may_be_of_real_time_if_the_simulation_is(read, settings):
    assert read(wall_clock_stamps=True, **settings).wall_clock_stamps


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"update_rate": 400},
            "~update_rate times ~step_size is 1; found 400 times 0.005, which is 2: set "
            "~update_rate to 200",
        ),
        ({"update_rate": "inf"}, "which is inf: set ~update_rate to 200"),
        ({"step_size": 0.01}, "found 200 times 0.01, which is 2: set ~update_rate to 100"),
        ({"train_mode": True}, "with ~train_mode time stands still between calls"),
        ({"others": {"/use_sim_time": True}}, "/use_sim_time is true, with which other nodes wait"),
    ],
)
def test_real_time_stamps_are_refused_with_other_rates(read, settings, message):
    with pytest.raises(FlatlandError, match=f"^~wall_clock_stamps: .*{message}"):
        read(wall_clock_stamps=True, **settings)


@pytest.mark.parametrize("value", [0, 1])
def test_a_flag_may_be_0_or_1_as_for_roslaunch(read, value):
    assert read(show_viz=value).show_viz is bool(value)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        (
            "world_path",
            "",
            "the parameter ~world_path must be the path of a world file: "
            "world_path:=PATH for roslaunch, _world_path:=PATH for rosrun",
        ),
        ("update_rate", 0, "~update_rate: expected a number above 0, found 0"),
        ("update_rate", True, "~update_rate: expected a number above 0, found True"),
        ("step_size", "inf", "~step_size: expected a number above 0, found inf"),
        ("viz_pub_rate", "nan", "~viz_pub_rate: expected a number above 0, found nan"),
        ("viz_pub_rate", [30], "~viz_pub_rate: expected a number above 0, found [30]"),
        ("seed", -1, "~seed: expected a whole number of 0 or more, found -1"),
        ("seed", True, "~seed: expected a whole number of 0 or more, found True"),
        ("simplify_map", 3, "~simplify_map: expected 0, 1 or 2, found 3"),
        ("show_viz", "yes", "~show_viz: expected true or false, found yes"),
        ("models", 5, "~models: expected a list of folders, found 5"),
        ("models", ["/", 5], "~models: expected a list of folders, found ['/', 5]"),
        ("models", "/:/nowhere", "~models: expected a folder, but /nowhere is none"),
        ("models", "package://", '~models: expected package://name/path, found "package://"'),
        ("world_path", "package://x", 'expected package://name/path, found "package://x"'),
        ("show_viz", 1.0, "~show_viz: expected true or false, found 1.0"),
    ],
)
def test_a_wrong_parameter_is_named(read, name, value, message):
    with pytest.raises(FlatlandError) as refusal:
        read(**{name: value})

    assert str(refusal.value) == message
