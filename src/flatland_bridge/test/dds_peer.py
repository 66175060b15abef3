"""A node of ROS 2 for tests of DDS: cyclonedds serializes its messages, value by value."""

import os
import random
import socket
from dataclasses import dataclass

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from waiting import wait_until

from flatland_bridge.dds_types import DdsTypes
from flatland_server.messages.message_types import get

RELIABLE = Qos(Policy.Reliability.Reliable(0), Policy.History.KeepLast(10))
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(10))
LATCHED = Qos(Policy.Reliability.Reliable(0), Policy.Durability.TransientLocal)


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec_: types.int32
    nanosec_: types.uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp_: Time
    frame_id_: str


@dataclass
class LaserScan(IdlStruct, typename="sensor_msgs::msg::dds_::LaserScan_"):
    header_: Header
    angle_min_: types.float32
    angle_max_: types.float32
    angle_increment_: types.float32
    time_increment_: types.float32
    scan_time_: types.float32
    range_min_: types.float32
    range_max_: types.float32
    ranges_: types.sequence[types.float32]
    intensities_: types.sequence[types.float32]


_TYPES = DdsTypes("jazzy")
_TYPES.message_class(get("flatland_msgs/ModelList"))  # which ROS 2 does not have
ModelList, Transforms, Twist, TwistStamped, String, Participant = map(
    _TYPES.struct,
    (
        "flatland_msgs/msg/ModelList",
        "tf2_msgs/msg/TFMessage",
        "geometry_msgs/msg/Twist",
        "geometry_msgs/msg/TwistStamped",
        "std_msgs/msg/String",
        "rmw_dds_common/msg/ParticipantEntitiesInfo",
    ),
)
Vector3 = _TYPES.struct("geometry_msgs/msg/Vector3")


class Peer:
    """A participant of a domain."""

    def __init__(self, domain):
        self.participant = DomainParticipant(domain)

    def reader(self, topic, kind, qos=RELIABLE):
        return DataReader(self.participant, Topic(self.participant, topic, kind), qos)

    def matched_reader(self, topic, kind, qos=RELIABLE):
        """A reader that has a writer."""
        reader = self.reader(topic, kind, qos)
        wait_until(lambda: reader.get_subscription_matched_status().current_count, topic)
        return reader

    def writer(self, topic, kind):
        """A writer that has a reader."""
        writer = DataWriter(self.participant, Topic(self.participant, topic, kind), RELIABLE)
        wait_until(lambda: writer.get_publication_matched_status().current_count, topic)
        return writer

    def endpoints(self, is_writers, topics):
        """The writers or readers by their topics, as soon as some topics have them."""
        kind = BuiltinTopicDcpsPublication if is_writers else BuiltinTopicDcpsSubscription
        reader = BuiltinDataReader(self.participant, kind)
        found = {}

        def has_all():
            found.update((each.topic_name, each) for each in reader.take(1000))
            return topics <= set(found)

        wait_until(has_all, "the topics")
        return found


def next_of(reader):
    """The next message of a reader."""
    return reader.take_one(timeout=duration(seconds=20))


def free_domain():
    """The number of a domain that no process uses."""
    for number in random.Random(os.getpid()).sample(range(1, 230), 100):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * number + 10))
                return number
            except OSError:
                continue
    raise AssertionError("no domain is free")
