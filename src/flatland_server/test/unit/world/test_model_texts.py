"""Models from a client's text: what it can name, and where its relative paths begin."""

import pytest
from world.parts import EMPTY

from flatland_server.exceptions import YamlError
from flatland_server.hub.client_files import told
from flatland_server.models.model import ModelText
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper

TEXT = "bodies: [{name: base, footprints: [{type: circle, radius: $eval 0.1 + 0.1, density: 1}]}]\n"


@pytest.fixture
def world(files):
    return World.from_file(files.write("world.yaml", EMPTY))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "<text of disc>: expected a map, found an empty file"),
        ("bodies: [\n", "<text of disc>:2: is not valid YAML"),
        ("plugins: []\n", '<text of disc>:1: the required key "bodies" is missing'),
        (f"{TEXT}---\n{TEXT}", "<text of disc>:3: expected one document"),
        pytest.param(TEXT + " " * (16 << 20), "<text of disc>: expected a file of", id="large"),
        ("[" * 200, "<text of disc>:1: expected at most 100 levels"),
        ("\nbodies: $include bodies.yaml", "<text of disc>:2: a text of a client cannot include"),
        ("bodies:\n- $[include] bodies.yaml", "<text of disc>:2: a text of a client cannot"),
        (
            TEXT.replace("0.1 + 0.1", "env('HOME')"),
            "<text of disc>:1: $eval: a text of a client cannot read environment variables",
        ),
    ],
)
def test_a_text_is_refused_at_its_line_and_reads_nothing_else(world, files, text, expected):
    files.write("bodies.yaml", "[{name: secret}]\n")

    with pytest.raises(YamlError) as error:
        world.spawn_model(ModelText(text, "disc"), "disc", "", (0, 0, 0))

    assert told(error.value).startswith("YamlError: ")
    assert expected in told(error.value)
    assert not world.models


def test_relative_paths_in_a_text_begin_in_the_worlds_folder(world, files):
    path = files.write("route.csv", "0, 0\n")
    text = f"{TEXT}plugins: [{{type: Any, name: any, route: route.csv}}]\n"

    model = world.read_model(ModelText(text, "disc"))

    assert model.plugins[0].reader.get_path("route") == path


def test_a_model_from_a_text_is_in_saved_states(world, files):
    world.spawn_model(ModelText(TEXT, "disc"), "disc", "", (1, 2, 0))
    state = Run(world, Timekeeper(0.005)).save_state()

    other = World.from_file(files.write("same.yaml", EMPTY))
    Run(other, Timekeeper(0.005)).load_state(state)

    model = other.get_model("disc")
    assert model.pose == (1, 2, 0)
    assert model.config == world.get_model("disc").config
    with pytest.raises(YamlError, match="cannot include"):  # still a text of a client
        other.spawn_model(ModelText("bodies: $include a.yaml", "b"), "b", "", (0, 0, 0))
