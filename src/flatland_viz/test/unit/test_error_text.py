"""The errors of services as users of the window read them."""

import pytest

from flatland_viz.error_text import error_text


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ('ModelError: a model named "a" is already there', 'a model named "a" is already there'),
        ("YamlError: a.yaml:3: no key\na.yaml:5: none", "a.yaml:3: no key\na.yaml:5: none"),
        ("ValueError: YamlError: twice", "YamlError: twice"),
        ("robot.yaml:4: not YAML", "robot.yaml:4: not YAML"),
        ("of an older server: ModelError: x", "of an older server: ModelError: x"),
        ("", ""),
    ],
)
def test_the_exception_class_is_left_out(message, text):
    assert error_text(message) == text
