"""Serialized messages as ROS 2 has them: its names and definitions of types, and CDR.

They are converted by the package rosbags, which has the definitions of ROS 2 itself. Of a type with
other fields there (`visualization_msgs/Marker`), fields are taken by their names, and new ones are
zero; the number of a header is left out. A type that ROS 2 does not have, such as those of
flatland_msgs, keeps the definition of ROS 1, with names of fields in lower case.
"""

from typing import Any, Callable, Dict, NamedTuple, Tuple

from flatland_server.exceptions import MissingPackageError

try:
    from rosbags.convert.converter import is_same_wireformat, migrate_bytes
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
except ImportError:
    get_typestore = None


class Ros2Type(NamedTuple):
    """A type of messages in ROS 2."""

    name: str
    """As package/msg/Name."""
    definition: str
    """The text of the type and of all types in it."""
    type_hash: str
    """Its hash by REP 2016, as RIHS01_ and 64 hexadecimal digits."""
    to_cdr: Callable[[bytes], bytes]
    """Turns a message that is serialized as in ROS 1 into CDR, little-endian, with its 4 bytes of
    encapsulation."""
    from_cdr: Callable[[bytes], bytes]
    """Turns CDR into a message that is serialized as in ROS 1; wrong data raises any exception."""


class Ros2Messages:
    """Types of ROS 1 as those of ROS 2; those that Flatland has are the same since Humble.

    Attributes:
        store: all types of ROS 2 that are known, in the form of rosbags.

    Raises:
        MissingPackageError: rosbags is not installed.
    """

    def __init__(self) -> None:
        if get_typestore is None:
            raise MissingPackageError("messages of ROS 2 need rosbags: pip install 'rosbags>=0.11'")
        self._ros1 = get_typestore(Stores.EMPTY)
        self.store = get_typestore(Stores.ROS2_HUMBLE)
        self._defaults: Dict[str, object] = {}
        self._types: Dict[str, Ros2Type] = {}

    def type_of(self, kind: Any) -> Ros2Type:
        """The type of ROS 2 of a message class.

        Args:
            kind: a class of `messages.get`, or of genpy.
        """
        known = self._types.get(kind._type)
        if known is None:
            known = self._types[kind._type] = self._read(kind)
        return known

    def _read(self, kind: Any) -> Ros2Type:
        name = kind._type.replace("/", "/msg/")
        fields = get_types_from_msg(kind._full_text, name)
        new = {key: each for key, each in fields.items() if key not in self._ros1.fielddefs}
        self._ros1.register(new)
        missing = [key for key in new if key not in self.store.fielddefs]
        self.store.register({key: _with_lower_case_names(new[key]) for key in missing})
        definition, _ = self.store.generate_msgdef(name, ros_version=2)
        return Ros2Type(name, definition, self.store.hash_rihs01(name), *self._converters(name))

    def _converters(self, name: str) -> Tuple[Callable[[bytes], bytes], Callable[[bytes], bytes]]:
        """Functions that turn messages of ROS 1 into CDR, and back."""
        ros1, ros2, cache = self._ros1, self.store, self._defaults
        if is_same_wireformat(ros1, ros2, name, name):
            return (
                lambda data: bytes(ros2.ros1_to_cdr(data, name)),
                lambda data: bytes(ros2.cdr_to_ros1(data, name)),
            )
        return (
            lambda data: bytes(
                migrate_bytes(ros1, ros2, name, name, cache, data, src_is2=False, dst_is2=True)
            ),
            lambda data: bytes(
                migrate_bytes(ros2, ros1, name, name, cache, data, src_is2=True, dst_is2=False)
            ),
        )


def _with_lower_case_names(definition: Any) -> Any:
    """The constants and fields of a type; ROS 2 allows no capitals in names of fields."""
    constants, fields = definition
    return constants, [(name.lower(), kind) for name, kind in fields]
