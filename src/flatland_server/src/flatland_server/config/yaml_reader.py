"""Checked values from YAML files, and errors with file and line.

A `YamlReader` reads one map. Its getters name a key, the type of its value and a default; `finish`
refuses the keys that no getter has asked for. The getter decides about the type, not YAML: `1e3`
and `inf` are numbers where a number is expected.

All problems of a document are reported together: a getter notes a problem and returns a
placeholder of the right type; `finish` raises what was noted. Do not use a value before that.
"""

import math
from pathlib import Path
from typing import Any, Callable, Hashable, List, Optional, Sequence, Set, Tuple, TypeVar, cast

import numpy as np
import yaml

from flatland_server.arrays import FloatArray
from flatland_server.config.file_names import find_file, is_bare, nor_in
from flatland_server.config.input_files import is_file, similar_file, why_not_a_file
from flatland_server.config.plain_nodes import to_node
from flatland_server.config.ros_names import FRAME, NAME, TOPIC, is_frame, is_name, is_topic
from flatland_server.config.yaml_map import REQUIRED as REQUIRED
from flatland_server.config.yaml_map import MutedCollector, YamlMap, file_of
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_values import (
    cells,
    float_from,
    floats_between,
    int_between,
    one_of,
    outlines,
    points,
    rows,
    text_of,
    to_bool,
    to_items,
    to_string,
    to_strings,
)
from flatland_server.exceptions import FlatlandError, YamlError, shortened
from flatland_server.geometry import Pose

T = TypeVar("T")

_TEXT_OF = "<text of "

Color = Tuple[float, float, float, float]
"""Red, green, blue and alpha, each 0 to 1."""


def is_text(file: Path) -> bool:
    """True if a problem's file stands for a text; see `YamlReader.from_text`."""
    return str(file).startswith(_TEXT_OF)


class YamlReader(YamlMap):
    """Reads one map: a whole document, an entry of a list, or a section of either.

        rate = reader.get_rate("update_rate", 10.0)
        angle = reader.get_section("angle", required=True)
        increment = angle.get_float("increment", above=0.0)
        angle.finish()
        reader.finish()

    A getter without a default is for a key that must be given. The arguments and errors of the
    class are those of `YamlMap`.
    """

    @classmethod
    def from_file(cls, path: Path, preprocessor: Optional[YamlPreprocessor] = None) -> "YamlReader":
        """The reader of a file, its includes and expressions resolved.

        Args:
            path: path of the YAML file.
            preprocessor: evaluates expressions; by default without parameters.

        Raises:
            YamlError: it is missing, unreadable, empty, not YAML or not a map.
        """
        return cls((preprocessor or YamlPreprocessor()).read(path))

    @classmethod
    def from_content(
        cls, content: Any, name: str, preprocessor: Optional[YamlPreprocessor] = None
    ) -> "YamlReader":
        """The reader of a file's content that a program has made, its expressions resolved.

        Args:
            content: plain data; see `plain_nodes.plain_copy`.
            name: stands for the file in errors, such as "world".
            preprocessor: evaluates expressions; by default without parameters.

        Raises:
            FlatlandError: it is no map of plain data, or an expression fails.
        """
        node = to_node(content, name)
        return cls((preprocessor or YamlPreprocessor()).resolve(node))

    @classmethod
    def from_text(
        cls, text: str, name: str, folder: Path, preprocessor: Optional[YamlPreprocessor] = None
    ) -> "YamlReader":
        """The reader of a text from a client, its expressions resolved.

        Args:
            text: YAML; see `YamlPreprocessor.read_text`.
            name: in errors, `<text of NAME>` stands for the file.
            folder: where relative paths begin.
            preprocessor: evaluates expressions; by default without parameters.

        Raises:
            YamlError: it is empty, not YAML or not a map.
        """
        file, root = Path(f"{_TEXT_OF}{name}>"), folder / "text"
        return cls((preprocessor or YamlPreprocessor()).read_text(text, file), root=root)

    def again(self) -> "YamlReader":
        """Another reader of the same map, with problems of its own."""
        return YamlReader(self._node, self.path, self._root)

    def read_once(self, read: Callable[..., T], *arguments: Hashable) -> T:
        """The result of `read(self, *arguments)`, kept for plugins that a reset starts again.

        Args:
            read: reads values into an object that does not change, and has no other effects.
            arguments: of `read`, after the reader.
        """
        key = (read, arguments)
        if key not in self._results:
            result = read(self, *arguments)
            if not self.is_sound:
                return result
            self._results[key] = result
        return cast(T, self._results[key])

    # Values

    def get_string(self, key: str, default: Any = REQUIRED) -> str:
        """A string; may be empty.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return cast(str, self._get(key, default, to_string, ""))

    def get_topic(self, key: str, default: Any = REQUIRED) -> str:
        """The name of a topic that ROS can have, relative or absolute.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return cast(str, self._get(key, default, text_of(is_topic, TOPIC), ""))

    def get_frame(self, key: str, default: Any = REQUIRED) -> str:
        """The name of a frame that TF can have; may begin with "/".

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return cast(str, self._get(key, default, text_of(is_frame, FRAME), ""))

    def get_name(self, key: str, default: Any = REQUIRED) -> str:
        """The name of a body, joint or plugin: any text of one line.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return cast(str, self._get(key, default, text_of(is_name, NAME), ""))

    def get_float(
        self,
        key: str,
        default: Any = REQUIRED,
        *,
        minimum: float = -math.inf,
        above: float = -math.inf,
        allow_infinity: bool = False,
    ) -> float:
        """A number; never NaN.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
            minimum: the least value that is allowed.
            above: bound that the value must exceed.
            allow_infinity: whether it may be infinite.
        """
        placeholder = 1.0 if minimum <= 1.0 and above < 1.0 else max(minimum, above + 1.0)
        converter = float_from(minimum, above, allow_infinity)
        return cast(float, self._get(key, default, converter, placeholder))

    def get_rate(self, key: str, default: Any = REQUIRED) -> float:
        """A rate above zero; `inf` is as often as possible [Hz].

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return self.get_float(key, default, above=0.0, allow_infinity=True)

    def get_int(
        self,
        key: str,
        default: Any = REQUIRED,
        *,
        minimum: Optional[int] = None,
        maximum: Optional[int] = None,
    ) -> int:
        """A whole number.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
            minimum: the least value that is allowed.
            maximum: the greatest value that is allowed.
        """
        return cast(int, self._get(key, default, int_between(minimum, maximum), minimum or 0))

    def get_bool(self, key: str, default: Any = REQUIRED) -> bool:
        """True or false, in any of YAML's spellings.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return cast(bool, self._get(key, default, to_bool, True))

    def get_choice(self, key: str, choices: Sequence[str], default: Any = REQUIRED) -> str:
        """One of some words.

        Args:
            key: key of this map, as it is written in the file.
            choices: the words that are allowed.
            default: the value if the key is missing; without it, the key is required.

        Raises:
            YamlError: at once, with all problems noted before: the choice decides about the other
                keys, so that there is no placeholder.
        """
        try:
            return cast(str, self._value(key, default, one_of(choices)))
        except YamlError as error:
            self.note(error)
            self.raise_problems()
            raise

    def get_floats(
        self, key: str, length: int, default: Any = REQUIRED, *, minimum: float = -math.inf
    ) -> Tuple[float, ...]:
        """A list of finite numbers.

        Args:
            key: key of this map, as it is written in the file.
            length: number of its entries.
            default: the value if the key is missing; without it, the key is required.
            minimum: the least number that is allowed.
        """
        expected = f"a list of {length} numbers"
        if minimum > -math.inf:
            expected += f" of {minimum:g} or more"
        placeholder = (max(0.0, minimum),) * length
        converter = floats_between(length, expected, minimum)
        return cast(Tuple[float, ...], self._get(key, default, converter, placeholder))

    def get_pose(self, key: str, default: Any = REQUIRED, *, is_motion: bool = False) -> Pose:
        """`[x, y, yaw]` [m, m, rad]; a yaw of more than a revolution is a warning.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
            is_motion: whether it is a motion, which may be of several revolutions.
        """
        pose = Pose(*self._get(key, default, floats_between(3, "[x, y, yaw]"), Pose()))
        if not is_motion:
            self.warn_of_degrees(pose.yaw, key)
        return pose

    def get_point(self, key: str, default: Any = REQUIRED) -> Tuple[float, float]:
        """`[x, y]` [m].

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        point = self._get(key, default, floats_between(2, "[x, y]"), (0.0, 0.0))
        return cast(Tuple[float, float], point)

    def get_points(
        self, key: str, minimum: int, maximum: int, default: Any = REQUIRED
    ) -> List[Tuple[float, float]]:
        """A list of points `[x, y]` [m].

        Args:
            key: key of this map, as it is written in the file.
            minimum: the least number of points.
            maximum: the greatest number of points.
            default: the value if the key is missing; without it, the key is required.
        """
        # Points of a parabola are the corners of a convex polygon, however many they are.
        placeholder = [(float(i), float(i * i)) for i in range(minimum)]
        found = self._get(key, default, points(minimum, maximum), placeholder)
        return cast(List[Tuple[float, float]], found)

    def get_rows(self, key: str, form: str, default: Any = REQUIRED) -> FloatArray:
        """A list of rows of numbers.

        Args:
            key: key of this map, as it is written in the file.
            form: of a row, such as "[x, y, radius]".
            default: the value if the key is missing; without it, the key is required.

        Returns:
            Shape (n, 3) for that form.
        """
        empty = np.empty((0, form.count(",") + 1))
        return cast(FloatArray, self._get(key, default, rows(form), empty))

    def get_outlines(self, key: str) -> List[FloatArray]:
        """A list of polygons, each of three or more points `[x, y]`; empty if it is not given.

        Args:
            key: key of this map, as it is written in the file.

        Returns:
            Each of shape (k, 2).
        """
        return cast(List[FloatArray], self._get(key, [], outlines, []))

    def get_cells(self, key: str) -> "np.ndarray[Any, Any]":
        """Rows of numbers or booleans, all of the same length.

        Args:
            key: key of this map, as it is written in the file.

        Returns:
            Shape (height, width).
        """
        return cast("np.ndarray[Any, Any]", self._get(key, REQUIRED, cells, np.zeros((1, 1))))

    def get_color(self, key: str, default: Any = REQUIRED) -> Color:
        """`[r, g, b, alpha]`, each 0 to 1.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        converter = floats_between(4, "[r, g, b, alpha], each 0 to 1", 0.0, 1.0)
        return cast(Color, self._get(key, default, converter, (0.0,) * 4))

    def get_strings(self, key: str, default: Any = REQUIRED) -> Tuple[str, ...]:
        """A list of strings; a single string is a list of one.

        Args:
            key: key of this map, as it is written in the file.
            default: the value if the key is missing; without it, the key is required.
        """
        return cast(Tuple[str, ...], self._get(key, default, to_strings, ()))

    def get_path(self, key: str, folders: Sequence[Path] = ()) -> Path:
        """An existing file: absolute, `package://name/path`, or relative to the document.

        For a key in a file that was included, it may also be relative to that file. For a document
        that is a symbolic link, "relative to the document" means relative to the link or else to
        its target.

        Args:
            key: key of this map at which the name of the file is given.
            folders: where a relative name without "./" is looked up after that.
        """
        beside = [self._root.parent, self._root.resolve().parent]
        try:
            name = cast(str, self._value(key, REQUIRED, to_string))
        except YamlError as error:
            self.note(error)
            return beside[0]
        beside.append(file_of(self._values[key]).parent)
        further = folders if is_bare(name) else ()
        try:
            path = find_file(name, [*beside, *further])
        except FlatlandError as error:
            self.problem(str(error), key)
            return beside[0]
        if not name:
            self.problem("expected a file, found an empty string", key)
        elif not is_file(path):
            hint = "" if is_text(self.file) else similar_file(path)
            found = f"{path} {why_not_a_file(path)}{hint}{nor_in(further)}"
            self.problem(f"expected a file, but {found}", key)
        return path

    # Sections

    def get_section(self, key: str, *, required: bool = False) -> "YamlReader":
        """A map within this one; an empty one if it is not given and not required.

        Its problems are noted with this map's: its own `finish` notes unknown keys, and leaves it
        to this map's `finish` to raise.

        Args:
            key: key of this map, as it is written in the file.
            required: whether a missing key is a problem.
        """
        self._read.add(key)
        path = self._path_of(key)
        problems = self._problems
        try:
            if self.has(key):
                return _Section(self._values[key], path, self._root, self._problems)
            if required and key not in self._values:
                raise self._missing(key)
        except YamlError as error:
            self.note(error)
            problems = MutedCollector(self._problems)
        empty = yaml.MappingNode("tag:yaml.org,2002:map", [], self._node.start_mark)
        return _Section(empty, path, self._root, problems)

    def get_sections(
        self, key: str, read: Callable[["YamlReader"], T], *, required: bool = False, word: str = ""
    ) -> List[T]:
        """Reads each map of a list; an empty list if it is not given.

        An entry for which `read` raises a YamlError is left out, and its problems are noted.

        Args:
            key: key of this map, as it is written in the file.
            read: called with the reader of an entry; returns its value.
            required: whether a missing list is a problem.
            word: the key that an entry of one word is short for; empty: entries must be maps.
        """
        entries: List[T] = []
        path = self._path_of(key)
        nodes = self._get(key, REQUIRED if required else [], to_items, [])
        for index, node in enumerate(nodes):
            if word and isinstance(node, yaml.ScalarNode):
                name = yaml.ScalarNode("tag:yaml.org,2002:str", word, node.start_mark)
                node = yaml.MappingNode("tag:yaml.org,2002:map", [(name, node)], node.start_mark)
            with self._problems.part() as problems:
                entries.append(read(YamlReader(node, f"{path}[{index}]", self._root, problems)))
        return entries

    def get_enabled_sections(
        self, key: str, read: Callable[["YamlReader"], T], *, required: bool = False
    ) -> List[T]:
        """Like `get_sections`, for entries with a `name` of their own and an `enabled` flag.

        An entry with `enabled: false` is left out, whatever else is in it.

        Args:
            key: key of this map, as it is written in the file.
            read: called with the reader of an entry; returns its value.
            required: whether a missing list is a problem.
        """
        names: Set[str] = set()
        enabled: List[T] = []

        def read_if_enabled(entry: "YamlReader") -> None:
            if not entry.get_bool("enabled", True):
                entry._problems.clear()
                return
            name = entry.get_string("name")
            if name and name in names:
                entry.problem(f'the name "{shortened(name)}" is given twice', "name")
            names.add(name)
            enabled.append(read(entry))

        self.get_sections(key, read_if_enabled, required=required)
        return enabled


class _Section(YamlReader):
    """A section: the document or entry that it is part of raises its problems."""

    def finish(self) -> None:
        self._note_unknown_keys()
