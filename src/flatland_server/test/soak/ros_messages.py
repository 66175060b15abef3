"""Random messages over ROS to all topics that a running server subscribes to."""

import random
from typing import Any, Dict

import tcpros_client
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from running_server import Master, Server
from soak.findings import Findings
from soak.random_messages import is_finite, random_message
from std_srvs.srv import Empty
from tcpros_publisher import Publishers
from waiting import wait_until

FEEDBACK = "/interactive_model_markers/feedback"
MOVES = "/move_model"
ROBOT = "soaked"
VICTIM = "victim"  # may be deleted by its context menu


def publish_at_random(
    server: Server, master: Master, seed: int, count: int, findings: Findings
) -> None:
    """Publishes `count` messages to each topic; then the robots can still be driven."""
    rng = random.Random(f"ros messages {seed}")
    for name in (ROBOT, VICTIM):
        findings.expect(server.spawn(name).success, f"seed {seed}: {name} is not spawned")
    types = dict(master.ask("getTopicTypes"))
    types = {topic: types[topic] for topic in master.subscribed_topics() if topic in types}
    expected = {f"/{ROBOT}/cmd_vel", FEEDBACK, MOVES}
    findings.expect(expected <= types.keys(), f"topics: {sorted(types)}")
    with Publishers(master, types) as publishers:
        wait_until(lambda: all(map(publishers.has_subscribers, types)), "the server to subscribe")
        for _ in range(count):
            for topic, message_type in types.items():
                message = random_message(message_type, rng)
                if topic == FEEDBACK:
                    aim(message, rng)
                if topic == MOVES:
                    message.name = rng.choice([ROBOT, VICTIM, message.name])
                publishers.send(topic, message)
                findings.counts["messages over ROS"] += 1
        of_victim = f"/{VICTIM}/"
        stays = [topic for topic in types if not topic.startswith(of_victim)]
        gone = [topic for topic in stays if not publishers.has_subscribers(topic)]
        findings.expect(not gone, f"seed {seed}: the server has left {gone}")
        server.call("/resume", Empty)  # dragging pauses
    check_odometry(server, seed, findings)
    check_diagnostics(server, seed, findings)
    findings.expect(server.delete(ROBOT).success, f"seed {seed}: {ROBOT} is not deleted")
    server.delete(VICTIM)
    findings.expect("Traceback" not in server.log, f"seed {seed}: a traceback in the log")


def aim(feedback: Any, rng: random.Random) -> None:
    """Makes most random feedback of interactive markers concern the models."""
    if rng.random() < 0.8:
        feedback.marker_name = rng.choice([ROBOT, VICTIM])
        feedback.event_type = rng.randrange(7)
        feedback.client_id = rng.choice(["/rviz1", "/rviz2", feedback.client_id])
        is_victim = feedback.marker_name == VICTIM
        feedback.menu_entry_id = rng.choice([0, 2, 3, 1 if is_victim else 7])


def check_odometry(server: Server, seed: int, findings: Findings) -> None:
    """The robot publishes finite odometry, and time goes on."""
    topics: Dict[str, Any] = {"odometry/ground_truth": Odometry, "odometry/filtered": Odometry}
    for topic, message_type in topics.items():
        with tcpros_client.subscribe(server.uri, f"/{ROBOT}/{topic}", message_type) as connection:
            message = tcpros_client.next_message(connection, message_type)
        findings.expect(is_finite(message.pose), f"seed {seed}: {topic}: {message.pose.pose}")
        findings.expect(is_finite(message.twist), f"seed {seed}: {topic}: {message.twist.twist}")
    with tcpros_client.subscribe(server.uri, "/clock", Clock) as connection:
        first, second = (tcpros_client.next_message(connection, Clock).clock for _ in range(2))
    findings.expect(second > first, f"seed {seed}: time stands still at {first}")


def check_diagnostics(server: Server, seed: int, findings: Findings) -> None:
    """No plugin has failed."""
    with tcpros_client.subscribe(server.uri, "/diagnostics", DiagnosticArray) as connection:
        message = tcpros_client.next_message(connection, DiagnosticArray)
    bad = [status for status in message.status if status.level >= status.ERROR]
    findings.expect(not bad, f"seed {seed}: {[(s.name, s.message) for s in bad]}")
