"""The command `flatland serve`: arguments, output, ends."""

import itertools
import json
import os
import re
import resource
import signal
import socket
import subprocess
import sys

import pytest
from bridge_clients import Client, connect
from test_greedy_clients import handshake
from waiting import wait_until

from flatland2d.cli import main

pytestmark = pytest.mark.slow


@pytest.fixture
def serve(world):
    """Starts the command as a process; returns it with the addresses that it prints."""
    processes = []

    def start(*arguments):
        command = [sys.executable, "-m", "flatland2d", "serve", str(world), *arguments]
        process = subprocess.Popen(
            [*command, "--port", "0", "--foxglove-port", "0"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        processes.append(process)
        lines = [process.stdout.readline() for _ in range(3)]
        return process, dict(re.match(r"(\w+): (\S+)$", line).groups() for line in lines)

    yield start
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_with_clients(serve, number):
    process, addresses = serve("--rate", "inf")
    client = connect(addresses["rosbridge"])
    client.send('{"op": "subscribe", "topic": "/clock"}')
    client.recv(timeout=20)

    process.send_signal(number)

    assert process.wait(20) == 0
    assert process.stderr.read() == ""


def test_a_random_token_is_printed_and_needed(serve):
    _, addresses = serve("--token", "--host", "127.0.0.1")

    assert all(len(re.search("token=(.*)", each)[1]) > 20 for each in addresses.values())
    connect(addresses["rosbridge"])
    with pytest.raises(Exception, match="401"):
        connect(addresses["rosbridge"].partition("?")[0])


def test_it_warns_if_others_can_connect(serve):
    process, _ = serve("--host", "0.0.0.0")
    process.send_signal(signal.SIGINT)

    assert "warning: everyone on the network can control" in process.stderr.read()


def test_a_port_in_use_is_named(world, capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["serve", str(world), "--port", str(port)]) == 1

    expected = f"flatland: rosbridge cannot listen at 127.0.0.1:{port}: Address already in use\n"
    assert capsys.readouterr().err == expected


@pytest.mark.parametrize("host", ["a..b", "::x"])
def test_a_host_that_is_none_is_named(world, capsys, host):
    assert main(["serve", str(world), "--port", "0", "--host", host]) == 1

    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith(f"flatland: rosbridge cannot listen at {host}:0: ")
    assert "Unknown error" not in error


@pytest.mark.parametrize("command", ["serve", "view"])
def test_a_missing_package_is_named(world, capsys, monkeypatch, command):
    for name in [name for name in sys.modules if name.startswith("flatland_bridge")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "orjson", None)

    assert main([command, str(world)]) == 1

    expected = f"flatland: flatland {command} needs orjson: pip install "
    assert capsys.readouterr().err.startswith(expected)


def test_clients_find_each_other_by_the_printed_address(serve):
    class Printed:
        class clients:
            url = None

    _, addresses = serve("--paused")
    Printed.clients.url = lambda name, scheme: addresses[name]
    assert Client(Printed).call("/step", steps=3)["values"]["time"]["nsecs"] == 15_000_000


def test_it_outlives_a_lack_of_file_descriptors(serve):
    process, addresses = serve("--paused")
    port = int(re.search(r":(\d+)/", addresses["rosbridge"])[1])
    few = len(os.listdir(f"/proc/{process.pid}/fd")) + 8
    limits = resource.prlimit(process.pid, resource.RLIMIT_NOFILE, (few, few))
    client = connect(addresses["rosbridge"])
    held = [socket.create_connection(("127.0.0.1", port)) for _ in range(12)]
    client.send('{"op": "call_service", "service": "/rosapi/nodes"}')
    assert "service_response" in client.recv(timeout=20)
    for each in held:
        each.close()

    late = connect(addresses["rosbridge"], open_timeout=20)

    late.send('{"op": "call_service", "service": "/rosapi/nodes"}')
    assert "service_response" in late.recv(timeout=20)
    assert limits[0] > few
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 0
    [line] = process.stderr.read().splitlines()
    assert line.endswith("no further client can connect for now: [Errno 24] Too many open files")


def memory(process):
    """The memory that a process has [MB]."""
    with open(f"/proc/{process.pid}/status") as file:
        return int(re.search(r"VmRSS:\s+(\d+)", file.read())[1]) / 1000


def test_stalled_clients_take_bounded_memory_and_return_it(serve):
    process, addresses = serve("--paused", "--client-memory", "4")
    url, topics = addresses["rosbridge"], [f"/t{number}" for number in range(3)]
    before = memory(process)
    port = int(re.search(r":(\d+)/", url)[1])
    stalled = [socket.create_connection(("127.0.0.1", port)) for _ in range(8)]
    for each in stalled:
        each.sendall(handshake(url))
        assert each.recv(1000).startswith(b"HTTP/1.1 101 ")
        for topic in topics:
            data = json.dumps({"op": "subscribe", "topic": topic}).encode()
            each.sendall(bytes([0x81, 0x80 | len(data), 0, 0, 0, 0]) + data)
    client = connect(url)
    for topic in topics:
        client.send(json.dumps({"op": "advertise", "topic": topic, "type": "std_msgs/String"}))
    for _, topic in itertools.product(range(12), topics):
        message = {"op": "publish", "topic": topic, "msg": {"data": "x" * 900_000}}
        client.send(json.dumps(message))
    client.send('{"op": "call_service", "service": "/rosapi/nodes"}')
    client.recv(timeout=60)

    assert memory(process) < before + 8 * 4 + 60

    for each in stalled:
        each.close()
    wait_until(lambda: memory(process) < before + 20, "the memory to return")
