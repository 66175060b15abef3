"""Training episodes: python3 -m flatland_benchmark.training_episodes EPISODES STEPS.

An episode resets the world, spawns 20 discs from a text, moves the robot, and makes steps of
/step_world, each of which is answered by a scan. Prints a line of JSON: the real time of each
episode without its steps, and of each step with its scan [s].
"""

import json
import sys
import time
from queue import Queue
from typing import Any, List

import rospy
from flatland_msgs.msg import MoveModelMsg
from flatland_msgs.srv import DeleteModels, Reset, SpawnModel
from geometry_msgs.msg import Pose2D
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty

_DISC = "bodies: [{name: disc, footprints: [{type: circle, radius: 0.1, density: 1}]}]"
_DISCS = [f"disc_{index}" for index in range(20)]
_LIMIT = 30.0  # s
_SETTLING = 0.5  # s: the messages of a step have arrived


def main(episodes: int, steps: int) -> None:
    """Runs the episodes."""
    rospy.init_node("training_episodes", disable_rostime=True)
    scans: Queue[LaserScan] = Queue()
    rospy.Subscriber("/scan", LaserScan, scans.put)
    move = rospy.Publisher("/move_model", MoveModelMsg, queue_size=1)
    _service("/pause", Empty)()  # time stands still between steps
    step = _service("/step_world", Empty)
    reset, spawn = _service("/reset", Reset), _service("/spawn_model_from_string", SpawnModel)
    delete = _service("/delete_models", DeleteModels)
    while scans.empty():  # the subscriptions are not connected yet
        step()
        time.sleep(_SETTLING)
    scans.queue.clear()
    prepared: List[float] = []
    stepped: List[float] = []
    for _ in range(episodes):
        begin = time.monotonic()
        _succeed(reset())
        for index, name in enumerate(_DISCS):
            _succeed(spawn(_DISC, name, "", Pose2D(-4.5 + 0.45 * index, -2.5, 0.0)))
        move.publish(MoveModelMsg("turtlebot", Pose2D(0.0, 1.0, 0.0)))
        prepared.append(time.monotonic() - begin)
        for _ in range(steps):
            begin = time.monotonic()
            step()
            scans.get(timeout=_LIMIT)
            stepped.append(time.monotonic() - begin)
        begin = time.monotonic()
        _succeed(delete(_DISCS))
        prepared[-1] += time.monotonic() - begin
    print(json.dumps({"prepared": prepared, "stepped": stepped}))


def _service(name: str, service: Any) -> rospy.ServiceProxy:
    rospy.wait_for_service(name, timeout=_LIMIT)
    return rospy.ServiceProxy(name, service, persistent=True)


def _succeed(answer: Any) -> None:
    if not answer.success:
        raise RuntimeError(answer.message)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
