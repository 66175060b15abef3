"""The errors of services as users read them: in the window (Python) and in rviz's tools (C++)."""

import shutil
import subprocess
from pathlib import Path
from typing import Callable

import pytest

from flatland_viz.error_text import error_text

TOOLS = Path(__file__).resolve().parents[2] / "src" / "tools"

MAIN = """
#include <iostream>
#include "error_text.hpp"
int main(int, char** arguments) { std::cout << flatland_viz::ErrorText(arguments[1]); }
"""


@pytest.fixture(scope="module", params=["python", pytest.param("c++", marks=pytest.mark.slow)])
def text_of(request, tmp_path_factory) -> Callable[[str], str]:
    """The function, in one of the two languages."""
    if request.param == "python":
        return error_text
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    folder = tmp_path_factory.mktemp("error_text")
    (folder / "main.cpp").write_text(MAIN)
    sources = [folder / "main.cpp", TOOLS / "error_text.cpp"]
    program = folder / "error_text"
    subprocess.run(
        [compiler, "-std=c++17", f"-I{TOOLS}", *map(str, sources), "-o", str(program)], check=True
    )
    return lambda message: (
        subprocess.run(
            [str(program), message], stdout=subprocess.PIPE, text=True, check=True
        ).stdout
    )


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ('ModelError: a model named "a" is already there', 'a model named "a" is already there'),
        (
            "YamlError: a.yaml:3: unknown key\na.yaml:5: no number",
            "a.yaml:3: unknown key\na.yaml:5: no number",
        ),
        ("ValueError: YamlError: twice", "YamlError: twice"),
        ("robot.yaml:4: not YAML", "robot.yaml:4: not YAML"),
        ("of an older server: ModelError: x", "of an older server: ModelError: x"),
        ("", ""),
    ],
)
def test_the_exception_class_is_left_out(text_of, message, text):
    assert text_of(message) == text
