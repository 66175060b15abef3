"""Access to the bridge and to files, and the cost of slow and hostile clients."""

import hashlib
import socket
import urllib.error
import urllib.request

import pytest
from bridge_clients import Client, connect, running
from websockets.exceptions import InvalidStatus

from flatland2d.cli import main
from flatland_bridge.budget import Budgets
from flatland_bridge.graph import BridgeError
from flatland_bridge.outbox import MOST_MESSAGES, Stream
from flatland_bridge.sample import Sample
from flatland_bridge.server import FOXGLOVE, ROSBRIDGE
from flatland_bridge.websocket_server import Access
from flatland_server.config.worlds import shipped_worlds


@pytest.mark.parametrize(
    ("origin", "is_allowed"),
    [
        ("http://localhost:8000", True),
        ("http://127.0.0.1", True),
        ("https://example.org", True),
        ("http://evil.example", False),
        ("http://localhost.evil.example", False),
        ("null", False),
    ],
)
@pytest.mark.parametrize("protocol", [ROSBRIDGE, FOXGLOVE])
def test_scripts_of_other_pages_cannot_connect(world, origin, is_allowed, protocol):
    with running(world, is_paused=True, access=Access(origins=["https://example.org"])) as server:
        url = server.clients.url(protocol, "ws")
        options = {"subprotocols": ["foxglove.sdk.v1"]} if protocol == FOXGLOVE else {}
        if is_allowed:
            connect(url, origin=origin, **options).close()
        else:
            with pytest.raises(InvalidStatus, match="403"):
                connect(url, origin=origin, **options)


@pytest.mark.parametrize("token", ["se/cret", "a b&c#d+é"])
def test_without_the_token_nobody_connects(world, token):
    with running(world, is_paused=True, access=Access(token=token)) as server:
        bare = f"ws://localhost:{server.clients.ports[ROSBRIDGE]}/"
        for url in (bare, f"{bare}?token=wrong", f"{bare}?token="):
            with pytest.raises(InvalidStatus, match="401"):
                connect(url)
        connect(server.clients.url(ROSBRIDGE, "ws")).close()
        if token.isascii():
            connect(bare, additional_headers={"Authorization": f"Bearer {token}"}).close()


def test_only_this_machine_can_connect(server):
    port = server.clients.ports[ROSBRIDGE]
    with socket.create_connection(("127.0.0.1", port)), pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", port))


def test_the_page_is_all_that_is_served(server):
    url = server.clients.url(ROSBRIDGE, "http")
    with urllib.request.urlopen(url) as page:
        assert "<canvas" in page.read().decode()
        policy = page.headers["Content-Security-Policy"]
        assert "default-src 'self'" in policy
        assert "frame-ancestors 'none'" in policy  # no other page can make its user click there
    for path in ("page.js/", "../server.py", "%2e%2e/server.py", "etc/passwd", "index.html?x=/.."):
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(url + path)


@pytest.mark.parametrize(
    ("service", "arguments"),
    [
        ("/spawn_model", {"yaml_path": "/etc/passwd", "name": "x"}),
        ("/spawn_model", {"yaml_path": "../secret.model.yaml", "name": "x"}),
        ("/open_world", {"path": "/etc/passwd"}),
        ("/get_model_markers", {"yaml_path": "/etc/hostname"}),
    ],
)
def test_clients_name_no_other_files(world, client, service, arguments):
    (world.parents[1] / "secret.model.yaml").write_text("bodies: []")

    answer = client.call(service, **arguments)["values"]

    assert not answer["success"]
    assert "root:" not in answer["message"]


def test_clients_save_states_only_where_they_may(world, client, tmp_path):
    assert "no service" in client.call("/save_state", path="/tmp/x")["values"]
    with running(world, is_paused=True, state_folder=tmp_path) as server:
        other = Client(server)
        assert other.call("/save_state", path="a.state")["values"]["success"]
        assert not other.call("/save_state", path="../a.state")["values"]["success"]
    assert (tmp_path / "a.state").is_file()


def test_a_too_long_message_disconnects_its_client_alone(server, client):
    other = Client(server)
    other.socket.send(" " * 2_000_000)
    with pytest.raises(Exception, match="1009"):
        other.receive()

    assert client.call("/rosapi/nodes")["result"]


def test_too_many_clients_are_refused(server):
    held = [Client(server) for _ in range(64)]
    with pytest.raises(InvalidStatus, match="503"):
        Client(server)
    for each in held:
        each.socket.close()


def test_a_stream_keeps_the_newest_messages():
    samples = [Sample("/x", number, None, data=b"") for number in range(10 * MOST_MESSAGES)]
    stream = Stream(encode=None, wake=lambda: None, budget=Budgets().open())
    for sample in samples:
        stream.receive(sample)

    first = stream.take(now=0.0)

    assert first.nanoseconds == 9 * MOST_MESSAGES
    short = Stream(encode=None, wake=lambda: None, budget=Budgets().open(), length=2)
    for sample in samples[:5]:
        short.receive(sample)
    assert [short.take(0.0) for _ in range(3)] == [*samples[3:5], None]
    throttled = Stream(encode=None, wake=lambda: None, budget=Budgets().open(), throttle=3600.0)
    for sample in samples[:3]:
        throttled.receive(sample)
    assert [throttled.take(now) for now in (0.0, 1e9)] == [samples[0], None]


def digest(server, client):
    """A digest of the run: where the robot is after each of some steps."""
    client.send("publish", topic="/cmd_vel", msg={"linear": {"x": 0.5}, "angular": {"z": 0.3}})
    result = hashlib.sha256()
    for _ in range(20):
        assert client.call("/step", steps=20)["values"]["success"]
        robot = server.manager.world.models["robot"]
        result.update(repr((robot.pose, server.manager.timekeeper.nanoseconds)).encode())
    return result.hexdigest()


def test_a_run_is_the_same_with_slow_stalled_and_dying_clients(world):
    with running(world, is_paused=True) as server:
        alone = digest(server, Client(server))

    with running(world, is_paused=True) as server:
        client, *others = (Client(server) for _ in range(5))
        for each in others:
            for topic in client.call("/rosapi/topics")["values"]["topics"]:
                each.subscribed(topic)
        others[0].socket.socket.close()  # dies without a word; the others never read
        assert digest(server, client) == alone


@pytest.mark.parametrize(
    "lines",
    [
        "GET //[ HTTP/1.1\r\nHost: localhost",
        "GET / HTTP/1.1\r\nUpgrade: websocket\r\nOrigin: a\r\nOrigin: b",
        "GET /?token=%ff HTTP/1.1\r\nUpgrade: websocket\r\nAuthorization: Bearer \xff",
        "GET / HTTP/1.1\r\nUpgrade: websocket\r\nOrigin: http://[",
    ],
)
def test_a_malformed_request_is_refused(world, lines):
    with running(world, is_paused=True, access=Access(token="secret")) as server:
        each = socket.create_connection(("127.0.0.1", server.clients.ports[ROSBRIDGE]))
        each.sendall(f"{lines}\r\n\r\n".encode("latin-1"))
        assert each.recv(1000).partition(b" ")[2][:3] in (b"400", b"401")
        each.close()


def test_an_empty_token_is_refused(world, capsys):
    with pytest.raises(BridgeError, match="token: expected one character or more"):
        Access(token="")
    assert main(["serve", str(world), "--token", ""]) == 1
    assert "token: expected one character" in capsys.readouterr().err


@pytest.mark.parametrize("with_states", [False, True])
def test_the_first_world_can_be_opened_again(world, with_states, tmp_path, monkeypatch):
    monkeypatch.chdir(world.parent)
    folder = {"state_folder": tmp_path / "states"} if with_states else {}
    for name in ("world.yaml", str(world), world):
        with running(name, is_paused=True, **folder) as server:
            client = Client(server)
            [path] = {each["world_resource"]["uri"] for each in worlds(client)} - shipped()
            for wanted in (str(name), path, str(world)):
                assert client.call("/open_world", path="office")["values"]["success"]
                opened = client.call("/open_world", path=wanted)["values"]
                assert opened["success"], opened
                assert server.manager.world.models.keys() == {"robot"}


def worlds(client):
    return client.call("/get_available_worlds")["values"]["worlds"]


def shipped():
    return {str(path) for path in shipped_worlds().values()}


def test_requests_that_never_end_are_limited(server):
    port = server.clients.ports[ROSBRIDGE]
    with socket.create_connection(("127.0.0.1", port)) as each:
        lines = "".join(f"X-{number}: {'x' * 5000}\r\n" for number in range(2000))
        with pytest.raises(OSError, match=r"reset|pipe"):
            each.sendall(b"GET / HTTP/1.1\r\n" + lines.encode())
