"""Reads YAML files into checked values: includes, Lua expressions, errors with file and line."""

from flatland_server.config.file_names import to_path
from flatland_server.config.input_files import (
    MAX_IMAGE,
    MAX_YAML,
    MIB,
    is_file,
    open_regular,
    read_input,
    refusal_by,
    replacing,
    require_free,
)
from flatland_server.config.ros_names import is_topic, namespace_problem, topic_name_problem
from flatland_server.config.worlds import SCENE_GOALS, find_world, is_shipped, shipped_worlds
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.config.yaml_values import LARGEST

__all__ = [
    "LARGEST",
    "MAX_IMAGE",
    "MAX_YAML",
    "MIB",
    "SCENE_GOALS",
    "YamlPreprocessor",
    "YamlReader",
    "find_world",
    "is_file",
    "is_shipped",
    "is_topic",
    "namespace_problem",
    "open_regular",
    "read_input",
    "refusal_by",
    "replacing",
    "require_free",
    "shipped_worlds",
    "to_path",
    "topic_name_problem",
]
