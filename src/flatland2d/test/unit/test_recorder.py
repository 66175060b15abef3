"""Recordings of a world in this process, read by ROS's rosbag, by rosbags and by mcap."""

import gc
import subprocess
from pathlib import Path
from typing import Any, List, NamedTuple, Tuple

import pytest
from without_ros import run_without_ros

from flatland2d import (
    MessageError,
    Pose,
    Recorder,
    RecordingError,
    Simulation,
    mcap_format,
    messages,
)
from flatland_server import LocalTransport, Timekeeper, Transform
from flatland_server.testing import Harness, WorldFiles

STEP = 5_000_000  # ns
ROBOT = (
    "type: DiffDrive, name: drive, body: base, pub_rate: 100",
    "type: Laser, name: laser, body: base, range: 4, update_rate: 50, "
    "angle: {min: -1, max: 1, increment: 0.5}",
    "type: Bumper, name: bumper, update_rate: 50",
)
Int32 = messages.get("std_msgs/Int32")


class Read(NamedTuple):
    """A message that was read."""

    topic: str
    nanoseconds: int
    message: Any


def record(path: Path, files: WorldFiles, topics=None, steps: int = 20) -> Harness:
    """Records a robot that drives."""
    simulation = files.robot(*ROBOT)
    recorder = Recorder(
        simulation.transport,
        simulation.timekeeper,
        path,
        topics,
        lambda: simulation.world.odometry_frames,
    )
    with recorder:
        simulation.drive(0.5, 0.2)
        for _ in range(steps):
            simulation.run()
            recorder.write_step()
    return simulation


def read_by_ros(path: Path) -> List[Read]:
    import rosbag

    with rosbag.Bag(str(path)) as bag:
        return [Read(topic, stamp.to_nsec(), message) for topic, message, stamp in bag]


def read_by_rosbags(path: Path) -> List[Tuple[str, str, int]]:
    from rosbags.rosbag1 import Reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    read = []
    with Reader(path) as reader:
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            assert store.generate_msgdef(connection.msgtype)[1] == connection.digest
        for connection, stamp, data in reader.messages():
            store.deserialize_ros1(data, connection.msgtype)
            read.append((connection.topic, connection.msgtype, stamp))
    return read


def read_by_mcap(path: Path, in_order: bool = True) -> List[Read]:
    from mcap.reader import make_reader
    from mcap_ros1.decoder import DecoderFactory

    with path.open("rb") as file:
        return [
            Read(channel.topic, message.log_time, decoded)
            for _, channel, message, decoded in make_reader(
                file, decoder_factories=[DecoderFactory()]
            ).iter_decoded_messages(log_time_order=in_order)
        ]


READERS = {".bag": read_by_ros, ".mcap": read_by_mcap}


@pytest.fixture
def files(tmp_path) -> WorldFiles:
    return WorldFiles(tmp_path)


@pytest.mark.parametrize("suffix", READERS)
def test_all_topics_are_recorded_with_the_simulated_time(suffix, tmp_path, files):
    path = tmp_path / f"run{suffix}"
    plain = files.robot(*ROBOT).drive(0.5, 0.2).run(0.1)

    simulation = record(path, files)

    read = READERS[suffix](path)
    topics = {each.topic for each in read}
    assert topics == {*simulation.transport.topics, "/clock", "/cmd_vel", "/tf", "/tf_static"}
    last = [each.message for each in read if each.topic == "/odometry/ground_truth"][-1]
    expected = simulation.last("/odometry/ground_truth")
    assert last.pose.pose.position.x == expected.pose.pose.position.x > 0.0
    assert last.header.stamp.to_nsec() == expected.header.stamp.to_nsec()
    scans = [each for each in read if each.topic == "/scan"]
    assert [each.nanoseconds for each in scans] == [
        max(1, 4 * i * STEP) if suffix == ".bag" else 4 * i * STEP for i in range(5)
    ]
    for each in scans[1:]:
        assert each.message.header.stamp.to_nsec() == each.nanoseconds
    assert [each.message.header.seq for each in scans] == [1, 2, 3, 4, 5]
    assert list(scans[-1].message.ranges) == pytest.approx([float("inf")] * 5)
    # The time comes before what happens at it.
    ticks = [each.message.clock.to_nsec() for each in read if each.topic == "/clock"]
    assert ticks == [i * STEP for i in range(21)]
    now = -1
    for each in read:
        now = each.message.clock.to_nsec() if each.topic == "/clock" else now
        assert now == each.nanoseconds or (now, each.nanoseconds) == (0, 1)
    # The run is the same as without a recording.
    assert simulation.model().pose == plain.model().pose
    assert simulation.last("/odometry/filtered") == plain.last("/odometry/filtered")


def test_transforms_of_one_time_are_one_message(tmp_path, files):
    path = tmp_path / "run.bag"

    record(path, files)

    read = read_by_ros(path)
    sent = [each.message.transforms for each in read if each.topic == "/tf"]
    # Every 10 ms that of the drive, every 20 ms also that of the laser.
    assert [[one.child_frame_id for one in transforms] for transforms in sent] == [
        ["base", "laser"],
        ["base"],
    ] * 5
    static = [each.message.transforms for each in read if each.topic == "/tf_static"]
    assert [[(one.header.frame_id, one.child_frame_id) for one in each] for each in static] == [
        [("map", "odom")]
    ]
    assert static[0][0].transform.rotation.w == 1.0


@pytest.mark.slow
def test_rosbag_and_rosbags_know_all_types_as_they_are(tmp_path, files):
    path = tmp_path / "run.bag"
    record(path, files)

    checked = subprocess.run(["rosbag", "check", path], capture_output=True, text=True)

    assert checked.returncode == 0, checked.stderr
    assert checked.stdout == "Bag file does not need any migrations.\n"
    read = read_by_rosbags(path)
    assert {(topic, kind) for topic, kind, _ in read} >= {
        ("/clock", "rosgraph_msgs/msg/Clock"),
        ("/collisions", "flatland_msgs/msg/Collisions"),
        ("/scan", "sensor_msgs/msg/LaserScan"),
        ("/tf", "tf2_msgs/msg/TFMessage"),
    }
    assert len(read) == len(read_by_ros(path))


@pytest.mark.parametrize(
    ("topics", "expected"),
    [
        (None, {"/scan", "/odometry/filtered", "/cmd_vel", "/collisions"}),
        ("all", {"/scan", "/odometry/filtered", "/cmd_vel", "/collisions"}),
        (["/scan"], {"/scan"}),
        (["scan", "cmd_vel"], {"/scan", "/cmd_vel"}),
        ("scan", {"/scan"}),
        (["/odometry/.*"], {"/odometry/filtered", "/odometry/ground_truth"}),
        ([".*/filtered", "/can"], {"/odometry/filtered"}),
        ([], set()),
    ],
)
def test_topics_are_chosen_by_name_or_by_expression(topics, expected, tmp_path, files):
    simulation = files.robot(*ROBOT)
    simulation.transport.set_subscribed_topics(())
    path = tmp_path / "run.bag"

    with Recorder(simulation.transport, simulation.timekeeper, path, topics) as recorder:
        simulation.drive(0.5)
        recorder.write_step()
        simulation.run()
        recorder.write_step()
        assert simulation.transport.transforms_have_subscribers
    is_computed = simulation.last("/scan") is not None
    assert is_computed == (topics != [] and "/scan" in expected)  # for the recording alone
    assert not simulation.transport.has_subscribers("/scan")
    assert not simulation.transport.transforms_have_subscribers

    recorded = {each.topic for each in read_by_ros(path)} - {"/clock", "/tf"}
    assert recorded >= expected
    if topics not in (None, "all"):
        assert recorded == expected


@pytest.mark.parametrize("suffix", READERS)
def test_latched_messages_from_before_are_recorded(suffix, tmp_path):
    transport, timekeeper = LocalTransport(), Timekeeper(0.005)
    timekeeper.jump_to(3 * STEP)
    latched = transport.advertise("/count", Int32, latch=True, queue_size=1)
    other = transport.advertise("/other", Int32, latch=False, queue_size=1)
    latched.publish(Int32(1))
    latched.publish(Int32(2))
    other.publish(Int32(3))

    with Recorder(transport, timekeeper, tmp_path / f"run{suffix}"):
        other.publish(Int32(4))

    read = READERS[suffix](tmp_path / f"run{suffix}")
    assert [(each.topic, each.nanoseconds) for each in read] == [
        ("/clock", 3 * STEP),
        ("/count", 3 * STEP),
        ("/other", 3 * STEP),
    ]
    assert [each.message.data for each in read[1:]] == [2, 4]


def test_a_bag_says_which_topics_are_latched(tmp_path):
    import rosbag

    transport = LocalTransport()
    transport.advertise("/count", Int32, latch=True, queue_size=1).publish(Int32(1))
    path = tmp_path / "run.bag"
    with Recorder(transport, Timekeeper(0.005), path, None, lambda: {("", "odom"), ("", "map")}):
        transport.send_transform(Transform(0, "odom", "base", Pose()))

    with rosbag.Bag(str(path)) as bag:
        latched = {c.topic: c.header["latching"] for c in bag._connections.values()}
    assert latched == {"/clock": b"0", "/count": b"1", "/tf": b"0", "/tf_static": b"1"}


def test_a_file_is_whole_once_the_recorder_is_closed(tmp_path, monkeypatch):
    path = tmp_path / "run.bag"
    Recorder(LocalTransport(), Timekeeper(0.005), path).close()
    before = path.read_bytes()
    monkeypatch.chdir(tmp_path)
    recorder = Recorder(LocalTransport(), Timekeeper(0.005), "run.bag")
    monkeypatch.chdir("/")

    assert path.read_bytes() == before
    assert (tmp_path / "run.bag.active").exists()
    recorder.close()
    recorder.close()

    assert [each.topic for each in read_by_ros(path)] == ["/clock"]
    assert not (tmp_path / "run.bag.active").exists()
    with pytest.raises(RecordingError, match=r"run\.bag: the recording is closed"):
        recorder.write_step()


def test_a_file_is_recorded_once_at_a_time(tmp_path):
    path = tmp_path / "run.mcap"
    recorder = Recorder(LocalTransport(), Timekeeper(0.005), path)

    with pytest.raises(RecordingError, match=r"run\.mcap: is being recorded already"):
        Recorder(LocalTransport(), Timekeeper(0.005), path)
    del recorder
    gc.collect()
    assert [each.topic for each in read_by_mcap(path)] == ["/clock"]
    Recorder(LocalTransport(), Timekeeper(0.005), path).close()


@pytest.mark.parametrize(
    ("name", "topics", "message"),
    [
        ("run.txt", None, "run.txt: expected a name that ends with .bag, .mcap"),
        ("none/run.bag", None, "none/run.bag: cannot be written: No such file or directory"),
        ("none/run.mcap", None, "none/run.mcap: cannot be written: No such file or directory"),
        ("run.bag", ["/scan", "/a("], "a regular expression that matches names, found '/a('"),
        ("run.bag", [3], "expected the name of a topic, or a regular expression"),
    ],
)
def test_a_recording_that_cannot_be_made_is_refused(name, topics, message, tmp_path):
    transport = LocalTransport(subscribed_topics=())

    with pytest.raises(RecordingError) as error:
        Recorder(transport, Timekeeper(0.005), tmp_path / name, topics)

    assert message in str(error.value)
    assert not transport.has_subscribers("/scan")
    assert list(tmp_path.iterdir()) == []


def test_a_value_that_is_no_message_is_refused_with_its_topic(tmp_path):
    transport = LocalTransport()
    recorder = Recorder(transport, Timekeeper(0.005), tmp_path / "run.bag")

    transport.send("/count", 7)

    with pytest.raises(MessageError, match='a message on the topic "/count", found 7'):
        recorder.write_step()
    recorder.close()


def test_an_mcap_is_larger_without_zstandard_but_the_same(tmp_path, files, monkeypatch):
    record(tmp_path / "small.mcap", files)
    monkeypatch.setattr(mcap_format, "zstandard", None)
    record(tmp_path / "large.mcap", files)

    small, large = (
        [(each.topic, each.nanoseconds, str(each.message)) for each in read_by_mcap(path)]
        for path in (tmp_path / "small.mcap", tmp_path / "large.mcap")
    )
    assert small == large
    assert (tmp_path / "large.mcap").stat().st_size > 2 * (tmp_path / "small.mcap").stat().st_size


PROGRAM = """
from pathlib import Path
import test_recorder
from flatland_server.testing import WorldFiles
folder = Path(sys.argv[1])
for name in ("run.bag", "run.mcap"):
    test_recorder.record(folder / name, WorldFiles(folder))
left_open = test_recorder.Recorder(
    test_recorder.LocalTransport(), test_recorder.Timekeeper(0.005), folder / "open.bag"
)
"""


@pytest.mark.slow
def test_without_ros_the_same_is_recorded(tmp_path):
    for name in ("with", "without"):
        (tmp_path / name).mkdir()
    run_without_ros(PROGRAM, tmp_path / "without")
    for name in ("run.bag", "run.mcap"):
        record(tmp_path / "with" / name, WorldFiles(tmp_path / "with"))

    for name, read in (("run.bag", read_by_ros), ("run.mcap", read_by_mcap)):
        with_ros, without = (
            [(each.topic, each.nanoseconds, str(each.message)) for each in read(folder / name)]
            for folder in (tmp_path / "with", tmp_path / "without")
        )
        assert without == with_ros
        assert len(without) > 50
    # The end of the program has finished what was not closed.
    assert [each.topic for each in read_by_ros(tmp_path / "without" / "open.bag")] == ["/clock"]


def test_each_run_has_a_file_of_its_own(tmp_path):
    """A reset, a seek and a state lead back: no reader could tell two runs at one time apart."""
    steps = (20, 12, 8, 6)
    with Simulation("office") as simulation:
        simulation.keep_history()
        with simulation.record(tmp_path / "run.bag", topics=["/scan"]):
            simulation.step(steps[0])
            simulation.reset(seed=2)
            simulation.step(steps[1])
            state = simulation.save_state()
            simulation.seek(0.02)
            simulation.step(steps[2])
            simulation.load_state(state)
            simulation.reset(keep_time=True)
            simulation.reset()
            simulation.step(steps[3])

    recordings = [tmp_path / name for name in ("run.bag", "run_1.bag", "run_2.bag", "run_3.bag")]
    assert sorted(tmp_path.glob("*.*")) == sorted(recordings)
    for path, count in zip(recordings, steps):
        read = read_by_ros(path)
        clocks = [each.nanoseconds for each in read if each.topic == "/clock"]
        assert clocks == sorted(set(clocks))
        assert len(clocks) >= count
        assert [each.nanoseconds for each in read] == sorted(each.nanoseconds for each in read)
        assert len([each for each in read if each.topic == "/tf_static"]) == 1
