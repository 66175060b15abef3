"""Subscribers of a topic with its type and without one, in one process, over a real master."""

import json
import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

PROGRAM = """
import json, sys
import rospy
from std_msgs.msg import String, UInt8
from waiting import wait_until
from flatland_server.ros.ros_transport import RosTransport

rospy.init_node("subscribers")
transport = RosTransport()
found = {}

class Listener:
    def __init__(self, topic, kind):
        self.messages = []
        self.subscription = transport.subscribe(topic, kind, self.messages.append)

    def next(self, publish=lambda: None):
        self.messages.clear()
        def has_come():
            publish()
            transport.process(0.02)
            return self.messages
        wait_until(has_come, "a message", 10.0)
        return self.messages[-1]

def plain(message):
    buffer = getattr(message, "_buff", None)
    return [getattr(message, "data", None), buffer.hex() if isinstance(buffer, bytes) else None]

def typed_and_raw(topic, order, **options):
    publisher = rospy.Publisher(topic, String, queue_size=10, **options)
    publish = lambda: None if options else publisher.publish("hello")
    if options:
        publisher.publish("hello")
    listeners = {}
    for name in order:
        listeners[name] = Listener(topic, String if name == "typed" else rospy.AnyMsg)
        listeners[name].next(publish)  # the first is connected before the second comes
    results = {n: plain(each.messages[-1]) for n, each in listeners.items()}
    listeners[order[0]].subscription.close()
    if not options:
        results["left"] = plain(listeners[order[1]].next(publish))
    again = Listener(topic, String if order[0] == "typed" else rospy.AnyMsg)
    results["again"] = plain(again.next(publish))
    return results

for order in ("raw typed", "typed raw"):
    for options in ({}, {"latch": True}):
        name = f"{order} {'latched' if options else 'stream'}"
        found[name] = typed_and_raw("/" + name.replace(" ", "_"), order.split(), **options)

changing = Listener("/changing", rospy.AnyMsg)
for kind, value in ((String, "hello"), (UInt8, 7), (String, "again")):
    publisher = rospy.Publisher("/changing", kind, queue_size=10)
    typed = Listener("/changing", kind)
    changing.next(lambda: publisher.publish(value))
    found[f"changing {value}"] = plain(typed.next(lambda: publisher.publish(value)))
    typed.subscription.close()
    publisher.unregister()
print(json.dumps(found))
"""
HELLO = "0500000068656c6c6f"


@pytest.fixture(scope="module")
def found(master):
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env={
            **os.environ,
            "ROS_MASTER_URI": master.uri,
            "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        },
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout.splitlines()[-1])


@pytest.mark.parametrize("kind", ["stream", "latched"])
@pytest.mark.parametrize("order", ["raw typed", "typed raw"])
def test_typed_and_raw_subscribers_each_get_their_form(found, order, kind):
    results = found[f"{order} {kind}"]
    first, second = order.split()

    assert results["typed"][0] == "hello"
    assert results["raw"][1] == HELLO
    left = {"left": second} if kind == "stream" else {}
    for name, which in {**left, "again": first}.items():
        assert results[name][which == "raw"] == (HELLO if which == "raw" else "hello"), name


def test_the_type_of_a_topic_may_change(found):
    assert [found[f"changing {value}"][0] for value in ("hello", 7, "again")] == [
        "hello",
        7,
        "again",
    ]
