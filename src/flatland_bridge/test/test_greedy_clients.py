"""Clients that take too much, or do not read: the simulation and the other clients go on."""

import json
import socket
import struct
import threading

import pytest
from bridge_clients import Client, connect, replace_service, running
from test_foxglove import Viewer
from waiting import wait_until
from websockets.exceptions import ConnectionClosed

from flatland_bridge.budget import Budgets
from flatland_bridge.client_calls import MOST_CALLS
from flatland_bridge.outbox import Stream
from flatland_bridge.sample import Sample
from flatland_bridge.server import ROSBRIDGE
from flatland_server.messages.message_types import get

MEMORY = 2_000_000
"""The budget of a client in these tests [bytes]."""

LONG, SLOW = "x" * 300_000, "/spawn_model_from_string"


@pytest.fixture
def server(world):
    """A paused simulation, for clients with little memory."""
    with running(world, is_paused=True, client_memory=MEMORY) as each:
        yield each


def stalled(server):
    """A client that does not read, with a small socket."""
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.connect(("localhost", server.clients.ports[ROSBRIDGE]))
    url = server.clients.url(ROSBRIDGE, "ws")
    each = Client.__new__(Client)
    each.socket = connect(url, sock=raw, max_queue=1, max_size=None)
    each.kept = []
    return each


def handshake(url):
    """The request to open a WebSocket."""
    path = url.partition("//")[2].partition("/")[2]
    return (
        f"GET /{path} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Version: 13\r\n\r\n"
    ).encode()


def ask_until_closed(client, ask, times=20):
    """Asks for much, and reads until the connection is closed."""
    for number in range(times):
        ask(number)
    while True:
        client.receive()


# Memory


def subscribe_under_long_ids(client, number):
    client.send("subscribe", topic="/scan", id=f"{number}{LONG}")


def send_parts_of_messages(client, number):
    client.send("fragment", id=str(number), num=0, total=2, data=LONG)


def offer_services(client, number):
    for index in range(200):
        client.send("advertise_service", service=f"/s{number}/s{index}", type="std_srvs/Empty")


def call_a_service_that_never_answers(client, number):
    client.send("call_service", service="/never", args={"data": LONG})


def make_calls_that_wait(client, number):
    client.send("call_service", service=SLOW, args={"yaml_path": LONG})


@pytest.mark.parametrize(
    "ask",
    [
        subscribe_under_long_ids,
        send_parts_of_messages,
        offer_services,
        call_a_service_that_never_answers,
        make_calls_that_wait,
    ],
)
def test_a_client_that_takes_too_much_is_told_and_disconnected(server, client, ask, monkeypatch):
    goes_on = threading.Event()
    replace_service(monkeypatch, server, SLOW, lambda request: goes_on.wait(60))
    provider, greedy = Client(server), Client(server)
    provider.send("advertise_service", service="/never", type="std_srvs/SetBool")
    provider.call("/rosapi/nodes")

    with pytest.raises(ConnectionClosed) as closed:
        ask_until_closed(greedy, lambda number: ask(greedy, number))

    assert closed.value.rcvd.code == 1008
    assert "--client-memory" in closed.value.rcvd.reason
    goes_on.set()
    wait_until(lambda: server.clients._budgets.total < 10_000, "the memory to be free")
    assert client.call("/rosapi/nodes")["result"]
    assert provider.call("/rosapi/nodes")["result"]


def test_a_viewer_that_takes_too_much_is_told_and_disconnected(server, monkeypatch):
    goes_on = threading.Event()
    replace_service(monkeypatch, server, SLOW, lambda request: goes_on.wait(60))
    viewer = Viewer(server)
    head = struct.pack("<BIII", 2, viewer.services[SLOW]["id"], 7, 4) + b"json"
    call = head + json.dumps({"yaml_path": LONG}).encode()

    with pytest.raises(ConnectionClosed) as closed:
        ask_until_closed(viewer, lambda number: viewer.socket.send(call))

    goes_on.set()
    assert closed.value.rcvd.code == 1008


def test_a_client_that_reads_slowly_loses_old_messages_and_stays(server, client):
    slow = stalled(server)
    for number in range(5):
        client.send("advertise", topic=f"/t{number}", type="std_msgs/String")
        slow.send("subscribe", topic=f"/t{number}")
    slow.call("/rosapi/nodes")
    for index in range(20):
        for number in range(5):
            client.send("publish", topic=f"/t{number}", msg={"data": f"{index} {LONG}"})
        client.call("/rosapi/nodes")
        assert all(each.waiting <= MEMORY for each in server.clients._budgets._open)

    client.send("publish", topic="/t0", msg={"data": "last"})
    while slow.receive()["msg"]["data"] != "last":
        pass

    assert slow.call("/rosapi/nodes")["result"]


def test_large_maps_reach_a_client_that_reads(world):
    """The walls are several times larger than the client's memory, in two latched messages."""
    lines = ", ".join(f"[{x / 10}, 0, {x / 10}, 1]" for x in range(3000))
    text = world.read_text().replace("[-5, 5, 5, 5], ", f"{lines}, ")
    world.write_text(text)
    topics = ("/flatland_server/debug/walls", "/flatland_server/debug/layers")
    with running(world, is_paused=True, client_memory=50_000) as server:
        client = Client(server, max_size=None)
        for topic in topics:
            client.send("subscribe", topic=topic)

        assert len(client.next_of(topics[0])["layers"][0]["segments"]) == 4 * 3001
        assert client.next_of(topics[1])["markers"]
        assert client.call("/rosapi/nodes")["result"]


@pytest.mark.slow
def test_the_server_ends_though_a_client_does_not_read(world):
    with running(world, is_paused=True) as server:
        client, each = Client(server), stalled(server)
        client.send("advertise", topic="/text", type="std_msgs/String")
        each.subscribed("/text")
        for _ in range(30):
            client.send("publish", topic="/text", msg={"data": LONG})
        client.call("/pause")
        [budget] = [each for each in server.clients._budgets._open if each.waiting]
        wait_until(lambda: budget.sending, "the socket to be full")
        ends = threading.Thread(target=server.close, daemon=True)
        ends.start()
        ends.join(10)

        assert not ends.is_alive()


def sample(number, size, *, is_latched=False):
    return Sample("/x", number, None, data=bytes(size), is_latched=is_latched)


def test_messages_beyond_the_budget_are_dropped_unless_latched():
    budget = Budgets(10_000).open()
    maps, scans = (Stream(None, lambda: None, budget) for _ in range(2))
    for number in range(50):
        scans.receive(sample(number, 500))

    maps.receive(sample(100, 90_000))
    assert maps.take(0.0) is None  # there is no room beside the scans
    maps.receive(sample(101, 90_000, is_latched=True))
    maps.receive(sample(102, 90_000, is_latched=True))
    assert budget.waiting <= 10_000
    assert (maps.take(0.0).nanoseconds, maps.take(0.0)) == (102, None)

    kept = [each.nanoseconds for each in iter(lambda: scans.take(0.0), None)]
    assert kept == list(range(50 - len(kept), 50))
    assert 3 <= len(kept) <= 10
    maps.receive(sample(103, 90_000))
    assert maps.take(0.0).nanoseconds == 103  # the only one may have any size
    assert budget.used == 0


def test_a_message_may_be_dropped_while_it_is_looked_at():
    budget = Budgets(10_000).open()
    stream, other = (Stream(None, lambda: None, budget) for _ in range(2))
    other.receive(sample(0, 500))
    stream.receive(sample(1, 500))
    delay = stream.delay
    stream.delay = lambda now: (delay(now), stream.receive(sample(2, 90_000)))[0]

    assert stream.take(0.0) is None


def test_nothing_is_kept_for_a_stream_that_is_closed():
    budget = Budgets(10_000).open()
    stream = Stream(None, lambda: None, budget)
    stream.receive(sample(1, 500))
    stream.close()
    stream.receive(sample(2, 500))

    assert budget.used == 0


def test_the_client_that_takes_most_memory_is_disconnected():
    reasons = {}
    budgets = Budgets(1000)
    clients = [budgets.open(lambda text, n=n: reasons.setdefault(n, text)) for n in range(17)]
    for number, each in enumerate(clients):
        each.hold(980 if number == 3 else 950)

    assert list(reasons) == [3]
    assert "all clients" in reasons[3]
    assert budgets.total == 16 * 950
    clients[3].close()
    clients[4].close()
    assert (budgets.total, len(budgets)) == (15 * 950, 15)


def test_answers_to_pings_that_are_not_read_are_limited(server):
    url = server.clients.url(ROSBRIDGE, "ws")
    each = socket.create_connection(("localhost", server.clients.ports[ROSBRIDGE]))
    each.sendall(handshake(url))
    assert each.recv(1000).startswith(b"HTTP/1.1 101 ")
    ping = bytes([0x89, 0x80 | 125, 0, 0, 0, 0]) + bytes(125)

    with pytest.raises(OSError, match=r"reset|pipe"):
        each.sendall(500_000 * ping)


# Calls


def test_a_client_waits_for_its_own_calls_alone(server, client, monkeypatch):
    goes_on, begun = threading.Event(), []

    def slow(request):
        begun.append(request.name)
        goes_on.wait(60)

    replace_service(monkeypatch, server, "/delete_model", slow)
    for number in range(MOST_CALLS + 1):
        args = {"name": str(number)}
        client.send("call_service", id=number, service="/delete_model", args=args)
    refused = client.receive()
    assert (refused["id"], refused["result"]) == (MOST_CALLS, False)

    other = Client(server)
    assert other.call("/move_model", name="robto")["values"]["success"] is False
    assert begun == ["0"]

    goes_on.set()
    assert [client.receive()["id"] for _ in range(MOST_CALLS)] == list(range(MOST_CALLS))
    assert begun == [str(number) for number in range(MOST_CALLS)]


def test_a_client_ends_the_step_for_which_it_waits(client):
    args = {"steps": 1, "expect": ["/cmd_vel"], "timeout": 1e6}
    client.send("call_service", id="step", service="/step", args=args)
    client.send("call_service", id="second", service="/step", args=args)
    client.send("call_service", id="pause", service="/pause")

    answers = {each["id"]: each["values"] for each in (client.receive() for _ in range(3))}

    assert "was paused" in answers["step"]["message"]
    assert "another request" in answers["second"]["message"]
    assert answers["pause"] == {}


def test_a_client_counts_until_its_last_call_has_ended(server, client, monkeypatch):
    goes_on, has_begun = threading.Event(), threading.Event()

    def action(request):
        has_begun.set()
        goes_on.wait(60)

    replace_service(monkeypatch, server, "/pause", action)
    other = Client(server)
    other.send("call_service", service="/pause")
    assert has_begun.wait(20)
    budgets = server.clients._budgets
    other.socket.close()
    client.call("/rosapi/nodes")
    assert len(budgets) == 2

    goes_on.set()
    wait_until(lambda: len(budgets) == 1, "the call to end")


def test_a_stalled_provider_does_not_disconnect_its_caller(server, client):
    provider = stalled(server)
    provider.send("advertise_service", service="/never", type="std_srvs/SetBool")
    provider.call("/rosapi/nodes")

    for number in range(1100):
        args = {"data": "x" * (200_000 if number < 5 else 10)}
        client.send("call_service", id=number, service="/never", args=args)

    for number in range(MOST_CALLS, 1100):
        refused = client.receive()
        assert (refused["id"], refused["result"]) == (number, False)
    assert client.call("/rosapi/nodes")["result"]
    provider.socket.socket.close()
    for _ in range(MOST_CALLS):
        assert client.receive()["values"] == "the client that offers it is gone"


def test_only_the_client_that_was_asked_answers(server, client):
    provider, liar = Client(server), Client(server)
    provider.send("advertise_service", service="/add", type="std_srvs/SetBool")
    provider.call("/rosapi/nodes")
    client.send("call_service", id="1", service="/add")
    asked = provider.receive()
    liar.send("service_response", id=asked["id"], values={"is": "a lie"}, result=True)
    liar.call("/rosapi/nodes")
    provider.send("service_response", id=asked["id"], values={"is": "true"}, result=True)

    assert client.receive()["values"] == {"is": "true"}


# The simulation's thread


class Name(str):
    """A topic's name that does something when it is looked up."""

    action = None

    def __hash__(self):
        if self.action is not None:
            self.action()
        return str.__hash__(self)


def test_subscriptions_may_change_while_they_are_gathered(server):
    """Another thread subscribes and leaves exactly while the subscribed topics are gathered."""
    graph, transport = server.graph, server.transport
    simulation = transport.call(threading.current_thread)
    name, others = Name("/scan"), []
    graph.subscribe(name, lambda message: None)
    transport.call(lambda: None)

    def come_and_go():
        for number in range(20):
            graph.subscribe(f"/t{number}", lambda message: None)()

    def interrupt():
        if threading.current_thread() is simulation:
            others.append(threading.Thread(target=come_and_go))
            others[-1].start()
            others[-1].join(0.2)

    name.action = interrupt
    transport.call(graph._follow_subscribers)
    name.action = None
    come_and_go()
    for other in others:
        other.join()
    transport.call(graph._follow_subscribers)

    assert graph._wanted == {"/scan"}


def test_a_client_that_fails_does_not_end_the_simulation(server, client, caplog):
    def fail(sample):
        raise RuntimeError("no client does this")

    for topic in ("/clock", "/tf", "/scan"):
        server.graph.subscribe(topic, fail)
    server.transport.post(lambda: fail(None))
    server.manager.world.transport.subscribe("note", get("std_msgs/String"), fail)
    client.send("publish", topic="/note", msg={"data": "x"})
    client.subscribed("/scan")

    assert client.call("/step", steps=40)["values"]["success"]
    assert client.next_of("/scan")
    assert len([each for each in caplog.messages if "fail has failed" in each]) == 1


def test_a_client_that_floods_the_simulation_is_refused_alone(server, client):
    goes_on = threading.Event()
    server.transport.post(lambda: goes_on.wait(60))
    other = Client(server)
    for _ in range(1200):
        client.send("publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}})
    for _ in range(200):
        assert "cannot keep up" in client.receive()["msg"]

    other.send("publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}})
    other.send("call_service", id="pause", service="/pause")
    other.send("publish", topic="/nowhere", msg={})
    assert 'no topic "/nowhere"' in other.receive()["msg"]
    goes_on.set()

    assert other.receive()["id"] == "pause"
    assert client.call("/rosapi/nodes")["result"]


def test_large_messages_that_do_not_fit_are_refused(server, client):
    goes_on = threading.Event()
    server.transport.post(lambda: goes_on.wait(60))
    client.send("advertise", topic="/text", type="std_msgs/String")
    for _ in range(10):
        client.send("publish", topic="/text", msg={"data": LONG})

    assert "cannot keep up" in client.receive()["msg"]
    goes_on.set()
    assert client.call("/pause")["result"]


# Messages that cannot be encoded


@pytest.mark.parametrize(("compression", "value"), [("none", 10**30), ("cbor-raw", 300)])
def test_an_unencodable_message_is_skipped_and_reported_once(server, client, compression, value):
    number = get("std_msgs/UInt8")
    publisher = server.transport.call(
        lambda: server.transport.advertise("/odd", number, latch=False, queue_size=1)
    )
    client.send("subscribe", topic="/odd", compression=compression)
    server.transport.call(lambda: None)
    client.call("/rosapi/nodes")
    for each in (value, value, 7):
        server.transport.call(lambda each=each: publisher.publish(number(each)))

    status = client.receive()
    assert status["op"] == "status"
    assert "/odd: messages that cannot be encoded" in status["msg"]
    assert client.receive()["topic"] == "/odd"
