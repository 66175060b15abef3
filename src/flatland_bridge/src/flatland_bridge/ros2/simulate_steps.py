"""The action SimulateSteps of simulation_interfaces, for which clients need ROS 2."""

import logging
import threading
from contextlib import suppress
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node

from flatland_bridge import simulation_types
from flatland_bridge.client_calls import reason_of
from flatland_bridge.graph import Graph
from flatland_bridge.ros2.types import interface
from flatland_bridge.simulation_results import Result

NAME = "/simulate_steps"
_REQUEST = simulation_types.service("StepSimulation").request(steps=1)

logger = logging.getLogger(__name__)


class SimulateSteps:
    """Makes the steps of one goal at a time, and tells of each. Further goals are rejected.

    Args:
        node: offers the action.
        graph: has the service that makes a step.

    Raises:
        MissingType: ROS 2 does not have the action.
    """

    def __init__(self, node: Node, graph: Graph) -> None:
        self._type = interface(f"{simulation_types.PACKAGE}/SimulateSteps", "action")
        self._graph = graph
        self._is_busy = False
        self._server = ActionServer(
            node,
            self._type,
            NAME[1:],
            lambda goal: None,  # each goal has a function of its own that ends it
            goal_callback=self._accept,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
        )
        # rclpy would make the steps on the executor's thread, on which all else would wait.
        self._end = self._server.notify_execute
        self._server.notify_execute = self._begin

    def close(self) -> None:
        """Offers it no longer."""
        self._server.destroy()

    def _accept(self, goal: Any) -> GoalResponse:
        if self._is_busy:
            logger.warning("%s: rejected, as another goal goes on", NAME)
        return GoalResponse.REJECT if self._is_busy else GoalResponse.ACCEPT

    def _begin(self, goal: Any, _: object) -> None:
        self._is_busy = True
        threading.Thread(target=self._execute, args=(goal,), name="steps", daemon=True).start()

    def _execute(self, goal: Any) -> None:
        """Makes steps until the goal is reached or cancelled, or one fails."""
        result, count = self._type.Result(), goal.request.steps
        result.result.result = Result.RESULT_OK
        with suppress(Exception):  # the node has ended
            for done in range(1, count + 1):
                made = self._step()
                if goal.is_cancel_requested:
                    made = Result(Result.RESULT_OPERATION_FAILED, f"cancelled after {done} steps")
                if made.result != Result.RESULT_OK:
                    result.result.result = made.result
                    result.result.error_message = made.error_message
                    break
                goal.publish_feedback(
                    self._type.Feedback(completed_steps=done, remaining_steps=count - done)
                )
            self._end(goal, partial(self._finish, result))

    def _step(self) -> Any:
        try:
            return self._graph.call("/step_simulation", _REQUEST).result
        except Exception as error:  # the goal would go on for ever, and no other one be accepted
            return Result(Result.RESULT_OPERATION_FAILED, reason_of(error, NAME))

    def _finish(self, result: Any, goal: Any) -> Any:
        """The result of a goal, which it ends; on the executor's thread."""
        self._is_busy = False
        if result.result.result == Result.RESULT_OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return result
