"""Messages that the core writes at each step: byte for byte those of the plugins' hooks."""

import contextlib
import socket
from collections import defaultdict
from typing import DefaultDict, List

import pytest

from flatland_plugins.diff_drive import DiffDrive
from flatland_plugins.laser import Laser
from flatland_plugins.model_tf_publisher import ModelTfPublisher
from flatland_server import _core
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginDeclaration, PluginLoader
from flatland_server.transport.local_transport import LocalTransport
from flatland_server.transport.transforms import SerializedFrames, TransformQueue
from flatland_server.transport.transport import Publisher


class Pusher(ModelPlugin):
    """Changes the robot's velocity, which those before it are not to see in this step."""

    def on_initialize(self, config):
        self._velocity = config.get_float("velocity")

    def before_physics_step(self, timekeeper):
        self.model.base.physics_body.velocity = (self._velocity, 0.0, timekeeper.seconds)


class WatchedDrive(DiffDrive):
    """Overrides a hook: the core must not write its messages without it."""

    def before_physics_step(self, timekeeper):
        super().before_physics_step(timekeeper)


class BytesTransport(LocalTransport):
    """Collects bytes by topic; those of steps are written by the core, if it may.

    Attributes:
        sent: the bytes of all messages of a topic, with their lengths.
        calls: how often plugins have written to a topic.
    """

    def __init__(self, by_core: bool) -> None:
        super().__init__()
        self.by_core = by_core
        self.sent: DefaultDict[str, bytes] = defaultdict(bytes)
        self.calls: DefaultDict[str, int] = defaultdict(int)
        self.outbox = _core.Outbox(1000.0, 1000)
        self.publishers: List[BytesPublisher] = []
        self.transforms_of_step = TransformQueue()

    def advertise(self, topic, message_type, *, latch, queue_size):
        self.publishers.append(BytesPublisher(self, topic))
        return self.publishers[-1]

    def send_transform(self, transform):
        self.transforms_of_step.add(transform)

    def open_frames(self, names):
        frames = SerializedFrames(self.transforms_of_step, names)
        if not self.by_core:
            frames.step_message = lambda poses: None
        return frames

    def flush(self):
        super().flush()
        self.sent["/tf"] += self.transforms_of_step.take()
        self.outbox.send()
        for publisher in self.publishers:
            publisher.receive()


class BytesPublisher(Publisher):
    has_subscribers = True

    def __init__(self, transport: BytesTransport, topic: str) -> None:
        self.transport, self.topic = transport, topic
        self.ours, self.theirs = socket.socketpair()
        self.theirs.setblocking(False)
        self.queue = _core.SubscriberQueue(self.ours.fileno(), 0, 0.0)

    def write(self, writer, *values):
        data = writer.data(*values)
        self.transport.calls[self.topic] += 1
        self.transport.sent[self.topic] += len(data).to_bytes(4, "little") + data

    def publish(self, message):
        raise NotImplementedError

    def step_message(self, message):
        if not self.transport.by_core:
            return None
        return _core.StepMessage(message, self.transport.outbox, [self.queue])

    def receive(self):
        with contextlib.suppress(BlockingIOError):
            self.transport.sent[self.topic] += self.theirs.recv(1_000_000)

    def close(self):
        self.queue.close()
        self.ours.close()
        self.theirs.close()


ODOMETRY = ("odometry/filtered", "odometry/ground_truth")
LASER = "type: Laser, body: base, range: 3, angle: {min: 0, max: 1, increment: 0.5}"
PUSHER = "type: Pusher, velocity: "
DRIFT = "odom_drift: {translation_per_metre: 0.1, rotation_per_radian: 0.1, track_width_bias: 0.1}"


def run(files, by_core: bool, drive: str) -> BytesTransport:
    """The messages of 50 steps of a robot that is pushed."""
    classes = (DiffDrive, ModelTfPublisher, Laser, Pusher, WatchedDrive)
    transport = BytesTransport(by_core)
    simulation = files.robot(
        f"name: before, {PUSHER}0.5",
        f"name: drive, body: base, enable_twist_pub: true, {drive}",
        f"name: laser, update_rate: 40, {LASER}",
        f"name: between, {PUSHER}0.25",
        "name: tf, type: ModelTfPublisher, publish_tf_world: true",
        loader=PluginLoader(map(PluginDeclaration.of, classes)),
        transport=transport,
    )
    for _ in range(50):
        simulation.run()
    simulation.close()
    return transport


@pytest.mark.parametrize(
    "drive",
    ["type: DiffDrive", "type: DiffDrive, twist_in_local_frame: true", f"type: DiffDrive, {DRIFT}"],
    ids=["exact", "local twist", "drift"],
)
def test_the_core_writes_the_bytes_that_hooks_do(files, drive):
    by_core = run(files, True, drive)
    by_hooks = run(files, False, drive)

    assert set(by_core.calls) == {"scan"}
    assert by_hooks.calls["odometry/filtered"] == 50
    assert set(by_core.sent) == {"scan", "twist", "/tf", *ODOMETRY}
    assert len(by_core.sent["odometry/filtered"]) > 50 * 700
    assert by_core.sent == by_hooks.sent


@pytest.mark.parametrize(
    "drive", ["type: WatchedDrive", "type: DiffDrive, odom_pose_noise: [1, 1, 1]"]
)
def test_the_core_leaves_hooks_of_derived_classes_and_noise_to_the_hooks(files, drive):
    transport = run(files, True, drive)

    assert transport.calls["odometry/filtered"] == 50
    assert len(transport.sent["odometry/filtered"]) > 50 * 700
