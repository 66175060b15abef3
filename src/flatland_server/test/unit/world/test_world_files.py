"""A world file is loaded completely or not at all; all problems are reported with their lines."""

import pytest
from world.parts import BODIES, EMPTY, Talker

from flatland_server.exceptions import FlatlandError
from flatland_server.simulation.world import World


def test_a_world_with_a_failing_model_leaves_no_topic(models, transport):
    entries = "models: [{name: a, model: good.yaml}, {name: b, model: bad.yaml}]"

    with pytest.raises(FlatlandError, match="no luck"):
        models.load(EMPTY + entries, transport=transport)

    assert (transport.topics, transport.subscribed) == (set(), set())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param("layers: []", '1: the required key "properties" is missing', id="properties"),
        pytest.param("properties: {}", '1: the required key "layers" is missing', id="layers"),
        pytest.param(
            "properties: {velocity_iteration: 5}\nlayers: []",
            '1: properties: unknown key "velocity_iteration" (did you mean "velocity_iterations"?)',
            id="unknown property",
        ),
        pytest.param(
            "properties: {position_iterations: 0}\nlayers: []",
            "1: properties.position_iterations: expected a whole number of 1 or more, found 0",
            id="no iteration",
        ),
        pytest.param(
            f"{EMPTY}model: []", '3: unknown key "model" (did you mean "models"?)', id="unknown key"
        ),
        pytest.param(
            f"{EMPTY}models:" + 2 * "\n  - {name: a, model: plain.yaml}",
            '5: models[1].name: the name "a" is given twice',
            id="two models of one name",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, model: none.yaml}}",
            "4: models[0].model: expected a file, but none.yaml is not there",
            id="no model file",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, model: plain.yaml, pose: foo}}",
            '4: models[0].pose: expected [x, y, yaw], found "foo"',
            id="no pose",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a b, model: plain.yaml}}",
            '4: models[0].name: expected a name of letters, digits and "_" '
            '(it names a ROS topic), found "a b"',
            id="a name with a space",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, model: plain.yaml, namespace: 1a}}",
            "4: models[0].namespace: expected a namespace of letters, digits and "
            '"_", beginning with a letter, found "1a"',
            id="a namespace that begins with a digit",
        ),
        pytest.param(
            f"{EMPTY}models:\n  - {{name: a, modle: plain.yaml}}",
            '4: models[0] "a": the required key "model" is missing\n'
            'world.yaml:4: models[0] "a": unknown key "modle" (did you mean "model"?)',
            id="a model without a file",
        ),
        pytest.param(
            f"{EMPTY}plugins:\n  - {{type: Talker, name: a}}",
            f'4: plugins[0].type: "Talker" is not a WorldPlugin: {Talker.__module__}.Talker',
            id="a model's plugin for the world",
        ),
    ],
)
def test_the_error_for_an_invalid_world_names_its_line(models, text, message):
    assert models.refusal(text) == f"world.yaml:{message}"


def test_all_problems_of_all_files_are_reported_at_once(models):
    models.write("wall.yaml", "type: line_segments\ndata: wall.dat\nscale: 0\norigin: foo\n")
    models.write("wall.dat", "")
    models.write("flawed.yaml", "bodies: [{name: base, footprints: []}]\njoints: 3\n")
    text = """\
properties: {friction: 1}
layers: [{name: a, map: wall.yaml}]
models:
  - {name: a, model: flawed.yaml}
  - {name: a, model: plain.yaml}
"""

    assert models.refusal(text).splitlines() == [
        'world.yaml:1: properties: unknown key "friction"',
        'wall.yaml:4: origin: expected [x, y, yaw], found "foo"',
        "wall.yaml:3: scale: expected a number above 0, found 0",
        "flawed.yaml:2: joints: expected a list, found 3",
        'world.yaml:5: models[1].name: the name "a" is given twice',
    ]


def test_all_plugins_that_do_not_start_are_reported_at_once(models):
    models.write("worse.yaml", f"{BODIES}plugins:\n  - {{type: Talkr, name: a}}\n")
    entries = "models: [{name: a, model: bad.yaml}, {name: b, model: worse.yaml}]"

    assert models.refusal(EMPTY + entries).splitlines() == [
        'bad.yaml:11: plugins[2] "c": no luck',
        'worse.yaml:9: plugins[0].type: unknown plugin type "Talkr" (did you mean "Talker"?); '
        "there are: Failing, Herald, Talker",
    ]


def test_a_number_of_iterations_beyond_the_range_of_box2d_is_refused(models):
    message = models.refusal("properties:\n  velocity_iterations: 3000000000\nlayers: []\n")

    assert message.startswith("world.yaml:2: properties.velocity_iterations: expected ")


def test_the_error_for_a_missing_world_file_names_it(tmp_path):
    with pytest.raises(FlatlandError) as caught:
        World.from_file(tmp_path / "world.yaml")

    assert str(caught.value) == (
        f"{tmp_path}/world.yaml: cannot be read: No such file or directory"
    )


def test_properties_may_be_empty(models):
    assert models.load("properties:\nlayers: []").physics.body_count == 0
