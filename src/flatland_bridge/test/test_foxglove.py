"""The Foxglove WebSocket protocol, read by its specification."""

import json
import struct

import pytest
from bridge_clients import Receiver, foxglove

from flatland_server import messages
from flatland_server.messages import service_types
from flatland_server.messages.wire_form import serialized

SUBPROTOCOLS = ("foxglove.websocket.v1", "foxglove.sdk.v1")


class Viewer(Receiver):
    """A client that knows channels and services by their names."""

    def __init__(self, server, subprotocol=SUBPROTOCOLS[0]):
        super().__init__(foxglove(server, subprotocol))
        self.channels, self.services = {}, {}
        self.info = self.receive()
        while not (self.channels and self.services):
            self.receive()

    def receive(self):
        data = self.socket.recv(timeout=20)
        message = data if isinstance(data, bytes) else json.loads(data)
        self.note(message)
        return message

    def note(self, message):
        if not isinstance(message, bytes):
            for channel in message.get("channels", ()):
                self.channels[channel["topic"]] = channel
            for service in message.get("services", ()):
                self.services[service["name"]] = service

    def send(self, **message):
        self.socket.send(json.dumps(message))

    def subscribe(self, topic, number):
        asked = [{"id": number, "channelId": self.channels[topic]["id"]}]
        self.send(op="subscribe", subscriptions=asked)

    def receive_binary(self, code):
        """The next binary message of a kind, without its code."""
        return self.receive_until(lambda each: isinstance(each, bytes) and each[0] == code)[1:]

    def receive_text(self, op):
        return self.receive_until(lambda each: isinstance(each, dict) and each["op"] == op)

    def call(self, name, encoding, payload):
        number = self.services[name]["id"]
        head = struct.pack("<BIII", 2, number, 7, len(encoding))
        self.socket.send(head + encoding.encode() + payload)
        answer = self.receive_binary(3)
        assert struct.unpack_from("<II", answer) == (number, 7)
        return answer[12 + len(encoding) :]


@pytest.fixture(params=SUBPROTOCOLS)
def viewer(server, request):
    each = Viewer(server, request.param)
    yield each
    each.socket.close()


def test_a_viewer_learns_topics_and_services_with_their_schemas(viewer):
    assert viewer.info["op"] == "serverInfo"
    assert set(viewer.info["capabilities"]) == {"clientPublish", "services", "time"}
    scan = viewer.channels["/scan"]
    assert (scan["encoding"], scan["schemaEncoding"]) == ("ros1", "ros1msg")
    assert scan["schemaName"] == "sensor_msgs/LaserScan"
    assert scan["schema"] == messages.get("sensor_msgs/LaserScan")._full_text
    assert "string yaml_path" in viewer.services["/spawn_model"]["request"]["schema"]


def test_a_viewer_drives_and_reads(viewer):
    viewer.subscribe("/scan", 5)
    viewer.subscribe("/flatland_server/debug/walls", 6)
    first = viewer.receive_binary(1)
    assert struct.unpack_from("<I", first)[0] == 6  # latched
    twist = messages.get("geometry_msgs/Twist")()
    twist.linear.x = 1.0
    channel = {"id": 3, "topic": "/cmd_vel", "encoding": "ros1"}
    viewer.send(op="advertise", channels=[{**channel, "schemaName": "geometry_msgs/Twist"}])
    viewer.socket.send(struct.pack("<BI", 1, 3) + serialized(twist))

    assert json.loads(viewer.call("/step", "json", b'{"steps": 200}'))["success"]

    number, nanoseconds = struct.unpack_from("<IQ", message := viewer.receive_binary(1))
    scan = messages.get("sensor_msgs/LaserScan")().deserialize(message[12:])
    assert (number, len(scan.ranges)) == (5, 401)
    assert nanoseconds == scan.header.stamp.to_nsec()


def test_services_answer_in_the_encoding_of_the_request(viewer):
    kind = service_types.get("flatland_msgs/MoveModel")
    request = serialized(kind.request(name="robto"))
    response = kind.response().deserialize(viewer.call("/move_model", "ros1", request))

    assert not response.success
    assert 'there is no model "robto"' in response.message


def test_new_topics_are_announced(viewer):
    asked = {"yaml_path": "robot.model.yaml", "name": "two", "ns": "two"}
    assert json.loads(viewer.call("/spawn_model", "json", json.dumps(asked).encode()))["success"]
    while "/two/scan" not in viewer.channels:
        viewer.receive_text("advertise")
    number = viewer.channels["/two/scan"]["id"]

    viewer.call("/delete_model", "json", b'{"name": "two"}')

    assert number in viewer.receive_text("unadvertise")["channelIds"]


def test_a_client_of_another_protocol_is_refused(server):
    with pytest.raises(Exception, match="400"):
        foxglove(server, "other.v1")
