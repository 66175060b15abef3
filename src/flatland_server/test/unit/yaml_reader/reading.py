"""Shared by the tests of YamlReader: reading a file, and the problems found in one."""

from pathlib import Path
from typing import Any, Callable

import pytest

from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import YamlError

Read = Callable[[YamlReader], Any]
SHAPES = ["circle", "polygon"]


def nothing(section: YamlReader) -> None:
    """Reads nothing of a section."""


def read(folder: Path, text: str) -> YamlReader:
    """A reader of a file with this text."""
    path = folder / "file.yaml"
    path.write_text(text, encoding="utf-8")
    return YamlReader.from_file(path)


def refusal(folder: Path, text: str, getter: Read) -> str:
    """The problems that a getter finds in a file with this text, without the folder's name."""

    def read_all() -> None:
        reader = read(folder, text)
        getter(reader)
        reader.raise_problems()

    with pytest.raises(YamlError) as caught:
        read_all()
    message = str(caught.value).replace(f"{folder}/", "")
    assert caught.value.line == int(message.split(":")[1])
    return message
