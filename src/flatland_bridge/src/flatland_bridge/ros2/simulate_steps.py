"""The action SimulateSteps of simulation_interfaces, for which clients need ROS 2."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node

from flatland_bridge import simulation_types
from flatland_bridge.client_calls import reason_of
from flatland_bridge.graph import Graph
from flatland_bridge.ros2.types import interface
from flatland_bridge.simulation_results import Result

NAME = "/simulate_steps"
_REQUEST = simulation_types.service("StepSimulation").request(steps=1)


class SimulateSteps:
    """Makes the steps of one goal at a time, and tells of each. A new goal ends the one before.

    So a client that has died holds up no others: ROS 2 does not tell servers of actions about it.

    Args:
        node: offers the action.
        graph: has the service that makes a step.

    Raises:
        MissingType: ROS 2 does not have the action.
    """

    def __init__(self, node: Node, graph: Graph) -> None:
        self._type = interface(f"{simulation_types.PACKAGE}/SimulateSteps", "action")
        self._graph = graph
        self._goal: Any = None  # the newest one
        self._pool = ThreadPoolExecutor(1, "steps")
        self._server = ActionServer(
            node,
            self._type,
            NAME[1:],
            lambda goal: None,  # each goal has a function of its own that ends it
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
        )
        # rclpy would make the steps on the executor's thread, on which all else would wait.
        self._end = self._server.notify_execute
        self._server.notify_execute = self._begin

    def close(self) -> None:
        """Offers it no longer."""
        self._goal = None
        self._pool.shutdown(wait=False)
        self._server.destroy()

    def _begin(self, goal: Any, _: object) -> None:
        self._goal = goal
        self._pool.submit(self._execute, goal)

    def _execute(self, goal: Any) -> None:
        """Makes steps until the goal is reached, cancelled or replaced, or one fails."""
        result, count = self._type.Result(), goal.request.steps
        result.result.result = Result.RESULT_OK
        with suppress(Exception):  # the node has ended
            for done in range(count):
                made = self._step(goal, done)
                if made.result != Result.RESULT_OK:
                    result.result.result = made.result
                    result.result.error_message = made.error_message
                    break
                goal.publish_feedback(
                    self._type.Feedback(completed_steps=done + 1, remaining_steps=count - done - 1)
                )
            self._end(goal, partial(self._finish, result))

    def _step(self, goal: Any, done: int) -> Any:
        """Makes the next step of a goal, if that goes on. Returns a result."""
        if goal.is_cancel_requested or goal is not self._goal:
            ended = "cancelled" if goal.is_cancel_requested else "replaced by another goal"
            return Result(Result.RESULT_OPERATION_FAILED, f"{ended} after {done} steps")
        try:
            return self._graph.call("/step_simulation", _REQUEST).result
        except Exception as error:  # the goal would never end
            return Result(Result.RESULT_OPERATION_FAILED, reason_of(error, NAME))

    def _finish(self, result: Any, goal: Any) -> Any:
        """The result of a goal, which it ends; on the executor's thread."""
        if result.result.result == Result.RESULT_OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return result
