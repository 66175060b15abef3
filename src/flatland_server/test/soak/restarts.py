"""Starts and ends of servers: killed ones, full disks, signals at any time."""

import contextlib
import os
import random
import signal
import subprocess
import time
from pathlib import Path
from typing import Iterator, List

from running_server import Master, Server
from soak.findings import Findings
from std_srvs.srv import Empty
from waiting import wait_until

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
END_LIMIT = 10.0  # s
START = 2.0  # s; a start takes 1 to 2


def killed_server(master: Master, folder: Path, findings: Findings) -> None:
    """A server is killed and started again: earlier publishers and subscribers continue."""
    with ended(Server(master, folder / "killed.log")) as server, contextlib.ExitStack() as clients:
        echo, out = folder / "echo.txt", "/odometry/filtered/twist/twist/linear/x"
        pub = ["rostopic", "pub", "-r", "20", "/cmd_vel", "geometry_msgs/Twist"]
        clients.enter_context(client(master, [*pub, "{linear: {x: 0.25}}"], folder / "pub.txt"))
        clients.enter_context(client(master, ["rostopic", "echo", out], echo))
        wait_until(lambda: "0.25" in echo.read_text(), "the robot to drive")
        server.kill()
        os.truncate(echo, 0)
        findings.expect("Traceback" not in server.log, "a traceback of a server that was killed")
        with ended(Server(master, folder / "again.log")) as again:
            wait_until(lambda: "0.25" in echo.read_text(), "the clients to find the new server")
            findings.expect("Traceback" not in again.log, "a traceback after the restart")


def full_disk(master: Master, findings: Findings) -> None:
    """Nothing can be written to the log: the server runs, and ends as always."""
    with ended(Server(master, Path("/dev/full"), is_awaited=False)) as server:
        wait_until(lambda: answers(server), "the services")
        findings.expect(not server.spawn("a b").success, "a wrong name on a full disk")
        findings.expect(server.spawn("robot").success, "no spawn on a full disk")
        server.process.send_signal(signal.SIGTERM)
        code = server.process.wait(END_LIMIT)
        findings.expect(code == 0, f"on a full disk, SIGTERM ended the server with {code}")


def signals_at_random(
    master: Master, folder: Path, rng: random.Random, count: int, findings: Findings
) -> None:
    """Signals at any time of a start end it without a traceback from our code."""
    for number in range(count):
        name, delay = rng.choice(SIGNALS), rng.uniform(0.0, START)
        log = folder / f"signal{number}.log"
        log.unlink(missing_ok=True)
        with ended(Server(master, log, is_awaited=False)) as server:
            time.sleep(delay)  # the time of the signal is what is varied
            what = f"{name.name} {delay:.3f} s after the start"
            server.process.send_signal(name)
            try:
                code = server.process.wait(END_LIMIT)
            except subprocess.TimeoutExpired:
                findings.expect(False, f"{what} has not ended the server: {server.log[-500:]}")
                continue
            findings.expect(code in (0, -name, 128 + name), f"{what}: ended with {code}")
            # Python itself may be interrupted before our first line.
            is_ours = "Traceback" in server.log and "flatland" in server.log
            findings.expect(not is_ours, f"{what}: {server.log[-1500:]}")
            findings.counts["signals during starts"] += 1


def answers(server: Server) -> bool:
    """True if its services can be called; the master may know those of one that was killed."""
    if not server.look_up():
        return False
    try:
        server.call("/pause", Empty)
    except OSError:
        return False
    return True


@contextlib.contextmanager
def ended(server: Server) -> Iterator[Server]:
    """A server that is killed at the end, whatever happens."""
    try:
        yield server
    finally:
        server.kill()


@contextlib.contextmanager
def client(master: Master, command: List[str], output: Path) -> Iterator[None]:
    """A program of ROS's, with its output in a file. It ends as by Ctrl-C.

    A publisher that is killed stays known to the master. Every later subscriber calls its address,
    and when another program has got that port for its TCPROS server, the call blocks this program's
    thread for new connections: rospy waits for the rest of a header of 1.4 GB ("POST").
    """
    with output.open("a") as file:
        process = subprocess.Popen(
            command,
            env={**os.environ, "ROS_MASTER_URI": master.uri},
            stdout=file,
            stderr=subprocess.STDOUT,
        )
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(END_LIMIT)
        finally:
            process.kill()
            process.wait()
