"""Misdeeds of a node of ROS 2, each beside another node: `ros2_misdeeds.py SEED SHARE`."""

import os
import random
import signal
import sys
import time

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import ListParameters, SetParameters
from rclpy.action import ActionClient
from sensor_msgs.msg import LaserScan
from simulation_interfaces.action import SimulateSteps
from std_srvs.srv import Empty

LIMIT = 30.0  # s; Fast DDS waits 0.1 s to send each response to a client that has gone
QUESTIONS = (Empty, "/resume"), (ListParameters, "/flatland_server/list_parameters")


def wrong_messages(node, rng, count):
    kind = rng.choice([LaserScan, Twist, TwistStamped])  # a process has one for a topic
    publisher = node.create_publisher(kind, "/cmd_vel", 10)
    node.create_subscription(LaserScan, "/clock", print, 10)
    for _ in range(count):
        publisher.publish(b"\0\1\0\0" + rng.randbytes(rng.randrange(40)))


def flood_of_calls(node, rng, count):
    for name in rng.sample(["/pause", "/resume", "/toggle_pause"], k=2):
        client = node.create_client(Empty, name)
        client.wait_for_service(LIMIT)
        for _ in range(count):
            client.call_async(Empty.Request())
    node.destroy_client(client)


def unknown_parameters(node, rng, count):
    client = node.create_client(SetParameters, "/flatland_server/set_parameters")
    client.wait_for_service(LIMIT)
    for name in rng.choices(["update_rate", "use_sim_time", "", "x" * 10_000], k=count):
        unknown = Parameter(name=name, value=ParameterValue(type=rng.randrange(256)))
        client.call_async(SetParameters.Request(parameters=[unknown]))


def abandoned_goals(node, rng, count):
    client = ActionClient(node, SimulateSteps, "/simulate_steps")
    client.wait_for_server(LIMIT)
    for _ in range(count):
        sent = client.send_goal_async(SimulateSteps.Goal(steps=rng.choice([0, 1, 2**64 - 1])))
        rclpy.spin_until_future_complete(node, sent, timeout_sec=rng.choice([0.0, 0.1]))
        if sent.done() and rng.random() < 0.5:
            sent.result().cancel_goal_async()


def is_served(node):
    """True if the server answers a node, and sends it scans."""
    scans = []
    node.create_subscription(LaserScan, "/scan", scans.append, 1)
    clients = [node.create_client(*each) for each in QUESTIONS]
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        calls = [client.call_async(client.srv_type.Request()) for client in clients]
        for call in calls:
            rclpy.spin_until_future_complete(node, call, timeout_sec=1.0)
        if scans and all(call.done() for call in calls):
            return True
    return False


if __name__ == "__main__":
    rclpy.init()
    for misdeed in (wrong_messages, flood_of_calls, unknown_parameters, abandoned_goals):
        rogue, honest = (rclpy.create_node(each + misdeed.__name__) for each in ("bad_", "good_"))
        misdeed(rogue, random.Random(sys.argv[1]), round(200 * float(sys.argv[2])))
        if not is_served(honest):
            sys.exit(f"after {misdeed.__name__}, the server did not serve another node")
    os.kill(os.getpid(), signal.SIGKILL)
