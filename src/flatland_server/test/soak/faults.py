"""Faults around a running server, which goes on."""

import random
import resource
import socket
import time

import tcpros_client
from flatland_msgs.srv import ChangeRate
from rosgraph_msgs.msg import Clock
from running_server import Master, Server, simulated_time
from sensor_msgs.msg import LaserScan
from soak.findings import Findings
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage
from waiting import wait_until

CALL_LIMIT = 5.0  # s; on an idle machine: some milliseconds


def stopped_subscribers(server: Server, findings: Findings) -> None:
    """Subscribers that read nothing, while the simulation is as fast as it can."""
    topics = {"/tf": TFMessage, "/scan": LaserScan, "/clock": Clock}
    stopped = [tcpros_client.subscribe(server.uri, *topic) for topic in topics.items()]
    with tcpros_client.subscribe(server.uri, "/clock", Clock) as clock:
        server.call("/change_rate", ChangeRate, rate=float("inf"))
        check_time(clock, 1.0, findings)
        server.call("/change_rate", ChangeRate, rate=1.0)
        check_time(clock, 0.2, findings)
    for connection in stopped:
        connection.close()


def silent_connections(server: Server, rng: random.Random, findings: Findings) -> None:
    """Connections on which nothing follows, or only half a header."""
    connections = [server.connect() for _ in range(rng.randint(1, 100))]
    header = b"\xff\x00\x00\x00half a header"
    for connection in connections:
        connection.sendall(header[: rng.randrange(len(header))])
    begin = time.monotonic()
    server.call("/pause", Empty)
    with tcpros_client.subscribe(server.uri, "/clock", Clock) as clock:
        server.call("/resume", Empty)
        tcpros_client.next_message(clock, Clock)
    seconds = time.monotonic() - begin
    findings.expect(seconds < CALL_LIMIT, f"with silent connections, two calls took {seconds} s")
    for connection in connections:
        connection.close()


def no_descriptors(server: Server, findings: Findings) -> None:
    """More connections than the server may have files open."""
    pid = server.process.pid
    soft, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    warnings = server.log.count("have to wait")
    used = server.open_files()
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (used + 20, hard))
    # Some of those used may be connections that are about to end.
    connections = [server.connect() for _ in range(used + 60)]
    wait_until(lambda: server.log.count("have to wait") > warnings, "the error")
    for connection in connections:
        connection.close()
    server.call("/pause", Empty)
    server.call("/resume", Empty)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (soft, hard))
    findings.expect(server.spawn("after").success, "no spawn after a lack of descriptors")
    findings.expect(server.delete("after").success, "no deletion after a lack of descriptors")


def dead_master(server: Server, master: Master, findings: Findings) -> None:
    """The master is killed and started again: it knows nothing then."""
    topics, subscribed = server.topics, server.subscribed_topics
    with tcpros_client.subscribe(server.uri, "/clock", Clock) as clock:
        master.kill()
        check_time(clock, 0.5, findings)
        findings.expect(server.spawn("without_master").success, "no spawn without a master")
        findings.expect(server.delete("without_master").success, "no deletion without a master")
        master.start()
        wait_until(lambda: topics <= master.topics(), "the topics to be registered again")
        wait_until(lambda: subscribed <= master.subscribed_topics(), "subscriptions, again")
        wait_until(lambda: master.ask("lookupService", "/pause"), "the services, again")
        wait_until(lambda: master.topics() == topics, f"the topics to be {sorted(topics)}")
        check_time(clock, 0.2, findings)


def check_time(clock: socket.socket, seconds: float, findings: Findings) -> None:
    """Simulated time goes on, as seen on a connection to /clock."""
    passed = simulated_time(clock, seconds)
    findings.expect(passed > 0.3 * seconds, f"{passed} s were simulated in {seconds} s")
