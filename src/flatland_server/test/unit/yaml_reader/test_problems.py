"""YamlReader: all problems of a file, unknown keys included, are reported together."""

from yaml_reader.reading import SHAPES, nothing, read, refusal

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.geometry import Pose


def test_all_problems_are_reported_in_the_order_of_reading(tmp_path):
    text = """\
properties: {gravity: heavy}
name: [a]
models:
  - {name: a, pose: foo, model: a.yaml}
  - {name: b, model: b.yaml}
  - {name: c}
  - d
weight: 1
"""

    def read_model(section: YamlReader) -> None:
        section.get_string("name")
        section.get_string("model")
        section.get_pose("pose", Pose())
        section.finish()

    def read_all(reader: YamlReader) -> None:
        properties = reader.get_section("properties")
        properties.get_float("gravity")
        properties.get_float("mass")
        properties.finish()
        reader.get_string("name")
        reader.get_sections("models", read_model)
        reader.finish()

    assert refusal(tmp_path, text, read_all).splitlines() == [
        'file.yaml:1: properties.gravity: expected a number, found "heavy"',
        'file.yaml:1: properties: the required key "mass" is missing',
        'file.yaml:2: name: expected a string, found ["a"]',
        'file.yaml:4: models[0].pose: expected [x, y, yaw], found "foo"',
        'file.yaml:6: models[2] "c": the required key "model" is missing',
        'file.yaml:7: models[3]: expected a map, found "d"',
        'file.yaml:8: unknown key "weight"',
    ]


def test_a_wrong_choice_raises_at_once_with_earlier_problems(tmp_path):
    def read_both(reader: YamlReader) -> None:
        reader.get_string("name")
        reader.get_choice("type", SHAPES)

    assert refusal(tmp_path, "type: cube", read_both).splitlines() == [
        'file.yaml:1: the required key "name" is missing',
        'file.yaml:1: type: expected circle or polygon, found "cube"',
    ]


def test_optional_keys_that_are_not_given_are_known(tmp_path):
    reader = read(tmp_path, "a: 1\nb:\n  - c: 2")
    reader.get_int("a")
    reader.get_string("other", "")

    counts = reader.get_sections("b", lambda section: (section.get_int("c"), section.finish())[0])

    reader.finish()
    assert counts == [2]


def test_an_unknown_key_has_the_line_of_the_key_not_of_its_value(tmp_path):
    def read_models(reader: YamlReader) -> None:
        reader.get_sections("models", nothing)
        reader.finish()

    message = refusal(tmp_path, "modles:\n  - name: robot\n", read_models)

    assert message == 'file.yaml:1: unknown key "modles" (did you mean "models"?)'


def test_problems_found_by_the_caller_have_places(tmp_path):
    def read_model(section: YamlReader) -> None:
        section.problem("there is no such body", "body")
        section.problem("is too heavy")
        section.raise_problems()

    text = "models:\n  - name: a\n    body: base"
    message = refusal(tmp_path, text, lambda reader: reader.get_sections("models", read_model))

    assert message.splitlines() == [
        "file.yaml:3: models[0].body: there is no such body",
        'file.yaml:2: models[0] "a": is too heavy',
    ]
