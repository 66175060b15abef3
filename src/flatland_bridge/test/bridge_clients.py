"""Servers of `flatland serve`, each in a thread of this process, and their clients."""

import json
import threading
from contextlib import contextmanager

import cbor2
from websockets.sync import client as websockets_client

from flatland_bridge.server import FOXGLOVE, ROSBRIDGE, Server

ROBOT = """
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.3, density: 1}]}
plugins:
  - {type: DiffDrive, name: drive, body: base}
  - type: Laser
    name: laser
    body: base
    range: 20
    update_rate: 20
    angle: {min: -2.0, max: 2.0, increment: 0.01}
"""
WORLD = """
properties: {}
layers:
  - name: hall
    map: {segments: [[-5, 5, 5, 5], [5, -5, 5, 5]]}
    color: [0.5, 0.5, 0.5, 1]
models:
  - {name: robot, model: robot.model.yaml}
"""

MOST_OTHERS = 1000
"""Messages of other kinds before a test gives up."""


@contextmanager
def running(world, **options):
    """A server that simulates in a thread; ends with the context."""
    goes_on = threading.Event()
    server = Server(world, **{"rosbridge_port": 0, "foxglove_port": 0, **options})
    with server:
        thread = threading.Thread(target=server.run, args=(lambda: not goes_on.is_set(),))
        thread.start()
        try:
            yield server
        finally:
            goes_on.set()
            thread.join()


def connect(url, **options):
    """A WebSocket that is open until it is closed, or its server.

    It sends no pings: if the server is gone, their failures would be logged in later tests.
    """
    return websockets_client.connect(url, ping_interval=None, **options).__enter__()


class Receiver:
    """Keeps messages that came before a wanted one. Subclasses have `receive`."""

    def __init__(self, socket):
        self.socket = socket
        self.kept = []

    def receive_until(self, is_wanted):
        """The first message of a kind; those before it can still be received."""
        for message in self.kept:
            if is_wanted(message):
                self.kept.remove(message)
                return message
        for _ in range(MOST_OTHERS):
            message = self.receive()
            if is_wanted(message):
                return message
            self.kept.append(message)
        raise AssertionError("the message did not come")


class Client(Receiver):
    """A client of rosbridge, made of a WebSocket and JSON alone."""

    def __init__(self, server, **options):
        super().__init__(connect(server.clients.url(ROSBRIDGE, "ws"), **options))

    def send(self, op, **fields):
        self.socket.send(json.dumps({"op": op, **fields}))

    def receive(self, timeout=20):
        data = self.socket.recv(timeout=timeout)
        return json.loads(data) if isinstance(data, str) else cbor2.loads(data)

    def call(self, name, /, **args):
        self.send("call_service", id="call", service=name, args=args)
        return self.receive_until(lambda each: each["op"] == "service_response")

    def subscribed(self, topic, **options):
        """Subscribes, and returns when the server has done so."""
        self.send("subscribe", topic=topic, **options)
        self.call("/rosapi/topics")
        return self

    def next_of(self, topic):
        return self.receive_until(lambda each: each.get("topic") == topic)["msg"]


def foxglove(server, subprotocol):
    return connect(server.clients.url(FOXGLOVE, "ws"), subprotocols=[subprotocol])


def replace_service(monkeypatch, server, name, action):
    """Makes a service of a server do something else."""
    services = server.graph._services
    monkeypatch.setitem(services, name, services[name]._replace(action=action))
