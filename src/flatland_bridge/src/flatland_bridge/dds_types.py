"""Types and names of ROS 2 as DDS has them.

https://design.ros2.org/articles/topic_and_service_names.html,
https://design.ros2.org/articles/mapping_dds_types.html
"""

import re
from typing import Any, Callable, Dict, Iterable

import numpy as np
from cyclonedds.idl import make_idl_struct, types
from rosbags.interfaces import Nodetype

from flatland2d.ros2_messages import Ros2Messages

DISCOVERY_TOPIC = "ros_discovery_info"
"""The topic of what `DdsTypes.discovery_message` makes, as DDS has it."""

_DISCOVERY = "rmw_dds_common/msg"
_TOPIC = re.compile(r"(/[A-Za-z_]\w*)+", re.ASCII)
_NUMBERS = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")
_BASES = {
    **{name: getattr(types, name) for name in (*_NUMBERS, "float32", "float64", "byte")},
    **{"bool": bool, "char": types.uint8, "octet": types.byte, "string": str},
}


class CdrMessage:
    """A message of a topic, serialized by its sender; a subclass for each type.

    It takes the place of cyclonedds' own structs, which would be serialized value by value.

    Args:
        data: CDR, with its 4 bytes of encapsulation.
    """

    __idl__: Any
    to_cdr: Callable[[bytes], bytes]
    from_cdr: Callable[[bytes], bytes]
    type_hash: str

    def __init__(self, data: bytes) -> None:
        self.data = data

    def serialize(self, **_: Any) -> bytes:
        """The bytes."""
        return self.data

    @classmethod
    def deserialize(cls, data: bytes) -> "CdrMessage":
        """A message of received bytes."""
        return cls(data)

    deserialize_key = deserialize


class DdsTypes:
    """The types of a participant.

    Args:
        distribution: of ROS 2.

    Raises:
        FlatlandError: rosbags is not installed, or does not know the distribution.
    """

    def __init__(self, distribution: str) -> None:
        self._messages = Ros2Messages(distribution)
        self._structs: Dict[str, Any] = {}
        self._classes: Dict[str, Any] = {}

    def message_class(self, kind: Any) -> Any:
        """The subclass of `CdrMessage` for the messages of a type.

        Args:
            kind: the class of the messages in the simulation.
        """
        ros2 = self._messages.type_of(kind)
        message_class = self._class(ros2.name)
        message_class.to_cdr = staticmethod(ros2.to_cdr)
        message_class.from_cdr = staticmethod(ros2.from_cdr)
        return message_class

    def _class(self, name: str) -> Any:
        """The class of a type of ROS 2."""
        if name in self._classes:
            return self._classes[name]
        content = {
            "__idl__": self.struct(name).__idl__,
            "type_hash": self._messages.store.hash_rihs01(name),
        }
        self._classes[name] = type("Message", (CdrMessage,), content)
        return self._classes[name]

    # Discovery

    def discovery_class(self) -> Any:
        """The class of the messages by which participants tell the names of their nodes."""
        return self._class(f"{_DISCOVERY}/ParticipantEntitiesInfo")

    def discovery_message(self, node: str, participant: bytes, *entities: Iterable[bytes]) -> Any:
        """A message that describes a participant with one node.

        Args:
            node: its name.
            participant: the id of the participant.
            entities: the ids of its readers, and those of its writers.
        """
        store = self._messages.store
        # 24 bytes in Humble and before, 16 since
        (_, (_, (_, length))) = store.fielddefs[f"{_DISCOVERY}/Gid"][1][0]
        gid = store.types[f"{_DISCOVERY}/Gid"]

        def to_gid(data: bytes) -> Any:
            return gid(np.frombuffer(data.ljust(length, b"\0"), np.uint8))

        readers, writers = ([to_gid(each) for each in ids] for ids in entities)
        node_info = store.types[f"{_DISCOVERY}/NodeEntitiesInfo"]("/", node, readers, writers)
        name = f"{_DISCOVERY}/ParticipantEntitiesInfo"
        info = store.types[name](to_gid(participant), [node_info])
        return self.discovery_class()(bytes(store.serialize_cdr(info, name)))

    def struct(self, name: str) -> Any:
        """The description of a type for discovery, as the generators of ROS 2 make it.

        Args:
            name: as package/msg/Name.
        """
        if name not in self._structs:
            package, _, bare = name.split("/")
            fields = {
                f"{key}_": self._type_of(kind)
                for key, kind in self._messages.store.fielddefs[name][1]
            }
            fields = fields or {"structure_needs_at_least_one_member_": types.uint8}
            self._structs[name] = make_idl_struct(
                f"{package}_{bare}_", f"{package}::msg::dds_::{bare}_", fields
            )
        return self._structs[name]

    def _type_of(self, kind: Any) -> Any:
        node, content = kind
        if node == Nodetype.BASE:
            name, length = content
            return types.bounded_str[length] if length else _BASES[name]
        if node == Nodetype.NAME:
            return self.struct(content)
        item, length = content
        if node == Nodetype.ARRAY:
            return types.array[self._type_of(item), length]
        kind = self._type_of(item)
        return types.sequence[kind, length] if length else types.sequence[kind]


def dds_topic(topic: str) -> str:
    """The name in DDS of a topic of ROS; empty if ROS 2 does not allow the topic's name."""
    return f"rt{topic}" if _TOPIC.fullmatch(topic) else ""
