"""Recordings with messages of ROS 2, read by mcap-ros2-support and rosbags."""

import re
from pathlib import Path

import pytest

from flatland2d import Simulation, messages
from flatland2d.cli import main

rosbags = pytest.importorskip("rosbags.highlevel", reason="rosbags needs Python 3.10")


def record(path: Path, ros2: bool) -> None:
    """Records the office, with a marker and one of our messages."""
    with Simulation("office") as simulation, simulation.record(path, ros2=ros2):
        simulation.models["turtlebot"].command(0.4, 0.3)
        transport = simulation.transport
        scale = messages.get("geometry_msgs/Vector3")(0.1, 0.2, 0.3)
        marker = messages.get("visualization_msgs/Marker")(ns="start", scale=scale)
        kind = messages.get("visualization_msgs/MarkerArray")
        transport.advertise("/markers", kind, latch=True, queue_size=1).publish(kind([marker]))
        collision = messages.get("flatland_msgs/Collision")(entity_A="robot", body_A="base")
        transport.send("/bumps", messages.get("flatland_msgs/Collisions")(collisions=[collision]))
        simulation.step(100)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """The same run as ROS 1 and as ROS 2 have it."""
    folder = tmp_path_factory.mktemp("recordings")
    for ros2 in (False, True):
        record(folder / f"ros{ros2 + 1}.mcap", ros2)
    return folder


def read_by_mcap(path, decoder):
    from mcap.reader import make_reader

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[decoder()])
        return reader.get_header(), list(reader.iter_decoded_messages())


def values(message):
    """The fields of a message and of those in it, without the numbers of headers."""
    if hasattr(message, "__slots__") and not hasattr(message, "to_nsec"):
        names = [name for name in message.__slots__ if name != "seq"]
        return {name.lower(): values(getattr(message, name)) for name in names}
    if hasattr(message, "secs"):
        return {"sec": message.secs, "nanosec": message.nsecs}
    return [values(each) for each in message] if isinstance(message, (list, tuple)) else message


def test_the_messages_are_those_of_ros_1(recordings):
    from mcap_ros1.decoder import DecoderFactory as Ros1
    from mcap_ros2.decoder import DecoderFactory as Ros2

    header, ros2 = read_by_mcap(recordings / "ros2.mcap", Ros2)
    _, ros1 = read_by_mcap(recordings / "ros1.mcap", Ros1)

    assert header.profile == "ros2"
    assert len(ros1) == len(ros2) > 150
    for former, new in zip(ros1, ros2):
        assert new.schema.encoding == "ros2msg"
        assert new.schema.name == former.schema.name.replace("/", "/msg/")
        assert (new.channel.topic, new.message.log_time) == (
            former.channel.topic,
            former.message.log_time,
        )
        if new.channel.topic != "/markers":
            assert values(new.decoded_message) == values(former.decoded_message)
    [marker] = next(
        each for each in ros2 if each.channel.topic == "/markers"
    ).decoded_message.markers
    assert (marker.ns, marker.scale.y, marker.texture_resource) == ("start", 0.2, "")


def test_the_types_and_the_quality_of_service_are_those_of_ros_2(recordings):
    """LaserScan's hash is the one that `ros2 topic info -v` shows."""
    from mcap_ros2.decoder import DecoderFactory as Ros2

    with rosbags.AnyReader([recordings / "ros2.mcap"]) as reader:
        connections = {each.topic: each for each in reader.connections}
        scans = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages([connections["/scan"]])
        ]

    assert len(scans) == 5
    assert all(len(scan.ranges) == len(scans[0].ranges) > 100 for scan in scans)
    _, recorded = read_by_mcap(recordings / "ros2.mcap", Ros2)
    scan = next(each.channel for each in recorded if each.channel.topic == "/scan")
    expected = "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"
    assert scan.metadata["topic_type_hash"] == expected
    latched = {topic for topic, each in connections.items() if each.ext.offered_qos_profiles}
    assert latched == {"/markers", "/tf_static"}
    [quality] = connections["/tf_static"].ext.offered_qos_profiles
    assert quality.durability.name == "TRANSIENT_LOCAL"


def test_a_recording_that_was_cut_stays_one_of_ros_2(recordings, tmp_path, capsys):
    cut = tmp_path / "cut.mcap.active"
    cut.write_bytes((recordings / "ros2.mcap").read_bytes()[:-100])

    assert main(["recover", str(cut)]) == 0

    with rosbags.AnyReader([tmp_path / "cut.mcap"]) as reader:
        assert {each.ext.serialization_format for each in reader.connections} == {"cdr"}
    assert main(["recover", str(cut), "-o", str(tmp_path / "cut.bag")]) == 1
    assert "cut.bag: expected a name that ends with .mcap for mess" in capsys.readouterr().err
    assert not (tmp_path / "cut.bag").exists()


def test_the_command_records_for_ros_2(tmp_path, capsys):
    path = tmp_path / "run.mcap"
    run = ["run", "office", "--seconds", "0.1"]

    assert main([*run, "--record", str(path), "--ros2", "--topics", "/scan"]) == 0
    with rosbags.AnyReader([path]) as reader:
        assert {each.msgtype for each in reader.connections} >= {"sensor_msgs/msg/LaserScan"}

    assert main([*run, "--record", str(tmp_path / "run.bag"), "--ros2"]) == 1
    assert re.search(r"run\.bag: expected a name that ends with \.mcap", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(SystemExit):
        main([*run, "--ros2"])
    assert "--ros2 says what to --record" in capsys.readouterr().err
