"""Several subscriptions of a client to one topic, each under an id of its own."""

import cbor2
import pytest
from bridge_clients import Client
from waiting import wait_until

ODOMETRY = "/odometry/filtered"
"""Comes at each step, before its /clock, with the time at which the step begins."""
RARE = 600_000  # ms, longer than any test


@pytest.fixture
def driver(server):
    """A client that gets all odometry, and the time of each step."""
    each = Client(server)
    each.subscribed(ODOMETRY, id="a").subscribed("/clock")
    each.next_of("/clock")  # the time of the pause in which it has come
    yield each
    each.socket.close()


def times_of(client, steps):
    """The simulated times at which some steps begin."""
    start = client.call("/rosapi/get_time")["values"]["time"]
    assert client.call("/step", steps=steps)["values"]["success"]
    ends = [client.next_of("/clock")["clock"] for _ in range(steps)]
    return [start, *ends[:-1]]


def received(client):
    """Counts the messages of odometry of 20 steps; one more /clock follows the last of them."""
    times = times_of(client, 21)[:-1]
    stamps = [each["msg"]["header"]["stamp"] for each in client.kept if each["op"] == "publish"]
    client.kept.clear()
    return sum(stamp in times for stamp in stamps)


def test_the_lowest_throttle_rate_of_live_subscriptions_counts(driver):
    found = [received(driver)]
    for op, options in (
        ("subscribe", {"id": "b", "throttle_rate": RARE}),
        ("unsubscribe", {"id": "b"}),
        ("unsubscribe", {"id": "other"}),
        ("unsubscribe", {"id": "a"}),
        ("subscribe", {"id": "b", "throttle_rate": RARE}),
        ("subscribe", {"id": "c"}),
        ("unsubscribe", {"id": "c"}),
        ("subscribe", {"id": "b"}),  # changes its mind
        ("subscribe", {}),
        ("unsubscribe", {"id": "b"}),
        ("subscribe", {"id": "b"}),
        ("unsubscribe", {}),
    ):
        driver.send(op, topic=ODOMETRY, **options)
        driver.call("/rosapi/nodes")
        found.append(received(driver))

    assert found == [20, 20, 20, 20, 0, 1, 20, 0, 20, 20, 20, 20, 0]


def test_the_longest_queue_counts_and_drains_without_throttle(driver):
    driver.send("unsubscribe", topic=ODOMETRY)
    for name, length in (("a", 2), ("b", 7), ("c", 1)):
        driver.subscribed(ODOMETRY, id=name, throttle_rate=RARE, queue_length=length)
    times_of(driver, 1)
    driver.next_of(ODOMETRY)  # the first one is not throttled
    times = times_of(driver, 20)

    driver.send("subscribe", topic=ODOMETRY, id="d")

    stamps = [driver.next_of(ODOMETRY)["header"]["stamp"] for _ in range(7)]
    assert stamps == times[-7:]
    assert received(driver) == 20


def test_the_smallest_fragment_and_best_compression_count(client):
    def form():
        """The length of the first fragment of a scan, or the type of its ranges."""
        client.call("/step", steps=10)
        first = client.receive_until(lambda each: each.get("topic") == "/scan" or "num" in each)
        for _ in range(first.get("total", 1) - 1):
            client.receive_until(lambda each: "num" in each)
        return len(first["data"]) if "data" in first else type(first["msg"].get("ranges"))

    found = []
    for op, options in (
        ("subscribe", {"id": "a"}),
        ("subscribe", {"id": "b", "fragment_size": 900}),
        ("subscribe", {"id": "c", "fragment_size": 500}),
        ("subscribe", {"id": "d", "fragment_size": 700}),
        ("subscribe", {"id": "e", "compression": "cbor"}),
        ("subscribe", {"id": "f", "compression": "cbor-raw"}),
        ("subscribe", {"id": "g", "compression": "cbor"}),
        ("unsubscribe", {"id": "f"}),
        ("unsubscribe", {"id": "e"}),
        ("unsubscribe", {"id": "g"}),
        ("unsubscribe", {"id": "c"}),
        ("unsubscribe", {"id": "d"}),
        ("unsubscribe", {"id": "b"}),
    ):
        client.send(op, topic="/scan", **options)
        client.call("/rosapi/nodes")
        found.append(form())

    cbor, raw = cbor2.CBORTag, type(None)
    assert found == [list, 900, 500, 500, cbor, raw, raw, cbor, cbor, 500, 700, 900, list]


def test_a_latched_message_comes_once_more_for_each_subscription(client):
    topic = "/flatland_server/debug/walls"
    client.subscribed(topic, id="a").next_of(topic)

    client.subscribed(topic, id="b")

    assert client.next_of(topic)["layers"]
    client.subscribed("/flatland_server/debug/layers").next_of("/flatland_server/debug/layers")
    assert [each for each in client.kept if each.get("topic") == topic] == []


def test_a_client_may_subscribe_to_a_topic_500_times(server, client):
    for number in range(500):
        client.send("subscribe", topic="/scan", id=number)
    assert client.call("/rosapi/nodes")["result"]
    client.send("subscribe", topic="/scan", id=0)  # again
    client.send("subscribe", topic="/scan", id="more")

    assert client.receive()["msg"] == "a client may subscribe to a topic 500 times"
    client.send("unsubscribe", topic="/scan")
    wait_until(lambda: server.clients._budgets.total == 0, "the memory to be free")
