"""The services of a graph in ROS 2, answered on threads of their own."""

import logging
import time
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any, Callable, Dict, List

from rclpy.node import Node
from rclpy.qos import QoSProfile

from flatland_bridge import simulation_types
from flatland_bridge.client_calls import reason_of
from flatland_bridge.graph import Graph
from flatland_bridge.ros2 import simulate_steps
from flatland_bridge.ros2.simulate_steps import SimulateSteps
from flatland_bridge.ros2.types import MissingType, Types, interface
from flatland_server.messages import ServiceType

logger = logging.getLogger(__name__)

_MOST_CALLS = 50
"""Calls that go on at the same time; some wait for simulated time. Others are refused."""
_QUEUE = 100
"""Requests to a service that wait for the node. Others are lost: their callers wait for ever."""
_STEPS = simulation_types.message("SimulatorFeatures").STEP_SIMULATION_ACTION


class Services:
    """Offers all services of a graph, and the action that ROS 2 has besides.

    Args:
        node: node of ROS 2 that offers the services.
        graph: graph with the services.
        types: the types of this ROS 2.
        missing: gets the names of services of types that this ROS 2 does not have, by type.
    """

    def __init__(
        self, node: Node, graph: Graph, types: Types, missing: Dict[str, List[str]]
    ) -> None:
        self._node = node
        self._graph = graph
        self._types = types
        self._pool = ThreadPoolExecutor(_MOST_CALLS, "call")
        self._responding = ThreadPoolExecutor(1, "respond")
        self._going_on = 0
        self._offered: Dict[str, Any] = {}
        offers: Dict[str, Callable[[], Any]] = {
            name: partial(self._offer, name, kind) for name, kind in graph.services.items()
        }
        offers[simulate_steps.NAME] = partial(SimulateSteps, node, graph)
        for name, offer in sorted(offers.items()):
            try:
                self._offered[name] = offer()
            except MissingType as error:
                missing.setdefault(str(error), []).append(name)

    def _offer(self, name: str, kind: ServiceType) -> Any:
        service = self._node.create_service(
            self._types.service(kind),
            name[1:],
            partial(self._begin, name, kind),
            qos_profile=QoSProfile(depth=_QUEUE),
        )
        # rclpy sends what the callback returns, which is the response's future here.
        service.send_response = partial(self._send_later, service.send_response)
        return service

    def _begin(self, name: str, kind: ServiceType, request: Any, response: Any) -> Any:
        """Begins a call, or returns its response if too many go on; on the executor's thread."""
        if self._going_on >= _MOST_CALLS:
            return self._failed(name, kind, f"{_MOST_CALLS} calls go on already")
        self._going_on += 1
        return self._pool.submit(self._answer, name, kind, request)

    def _end(self, _: "Future[Any]") -> None:
        self._going_on -= 1

    def _send_later(self, send: Any, done: Any, header: Any) -> None:
        """Sends the response of a call that `_begin` has begun, or that of one too many at once."""

        def respond(done: "Future[Any]") -> None:
            with suppress(RuntimeError):  # the node has ended
                sent = self._responding.submit(self._send, send, done.result(), header)
                sent.add_done_callback(self._end)

        if isinstance(done, Future):
            done.add_done_callback(respond)
        else:
            self._send(send, done, header)

    @staticmethod
    def _send(send: Any, response: Any, header: Any) -> None:
        """Sends a response, and leaves as much time to all other threads.

        Fast DDS waits 0.1 s for a client that has gone, and rclpy holds Python's lock meanwhile.
        """
        begin = time.monotonic()
        with suppress(Exception):  # the node has ended
            send(response, header)
        time.sleep(time.monotonic() - begin)

    def _answer(self, name: str, kind: ServiceType, request: Any) -> Any:
        """Makes a call, on a thread of the pool."""
        try:
            answer = self._graph.call(name, self._types.request(kind, request))
            if name == "/get_simulator_features" and simulate_steps.NAME in self._offered:
                answer.features.features.append(_STEPS)
            return self._types.response(kind, answer)
        except Exception as error:  # the caller would wait for ever
            return self._failed(name, kind, reason_of(error, name))

    @staticmethod
    def _failed(name: str, kind: ServiceType, reason: str) -> Any:
        """A response that says so, if it has the fields; ROS 2 has no errors of calls."""
        response = interface(kind.name, "srv").Response()
        if hasattr(response, "success"):
            response.message = reason
        elif hasattr(response, "result"):  # of simulation_interfaces
            response.result.result = response.result.RESULT_OPERATION_FAILED
            response.result.error_message = reason
        else:
            logger.error("%s: %s", name, reason)
        return response

    def close(self) -> None:
        """Begins no further call."""
        self._pool.shutdown(wait=False)
        self._responding.shutdown(wait=False, cancel_futures=True)
        if simulate_steps.NAME in self._offered:
            self._offered[simulate_steps.NAME].close()
