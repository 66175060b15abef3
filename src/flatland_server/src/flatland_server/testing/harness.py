"""A world that a test steps, and its topics."""

from typing import Any, List, Optional

from flatland_server.exceptions import UsageError
from flatland_server.messages.message_types import get
from flatland_server.models.model import Model
from flatland_server.simulation.run import Run
from flatland_server.simulation.world import World
from flatland_server.timekeeper import Timekeeper
from flatland_server.transport.local_transport import LocalTransport


class Harness(Run):
    """A world in a test: time passes in `run` only, and topics stay within the process.

    Args:
        world: what is simulated; its transport must be a `LocalTransport`.
        step_size: length of a step [s].
        allow_failures: whether plugins may fail. Otherwise `run` raises an AssertionError as soon
            as a plugin was switched off because it raised an exception.

    Attributes:
        files: the `WorldFiles` that it was loaded from, if any.

    Raises:
        UsageError: the transport is another one, or the step is no length of time.
    """

    transport: LocalTransport

    def __init__(
        self, world: World, step_size: float = 0.005, *, allow_failures: bool = False
    ) -> None:
        if not isinstance(world.transport, LocalTransport):
            raise UsageError(
                f"expected a world with a LocalTransport, found {type(world.transport).__name__}"
            )
        super().__init__(world, Timekeeper(step_size))
        self.allow_failures = allow_failures
        self.files: Any = None

    def model(self, name: str = "robot") -> Model:
        """A model by its name.

        Args:
            name: the model's name.

        Raises:
            ModelError: there is no such model.
        """
        return self.world.get_model(name)

    def run(self, seconds: Optional[float] = None) -> "Harness":
        """Advances the time, and returns this harness.

        Messages that were sent are received before the next step.

        Args:
            seconds: of simulated time; None is one step.

        Raises:
            AssertionError: a plugin has failed, and `allow_failures` is false.
        """
        steps = 1 if seconds is None else round(seconds / self.timekeeper.step_size)
        if steps > 0:
            self.step(steps)
        failures = self.world.plugin_failures
        if failures and not self.allow_failures:
            raise AssertionError(
                "\n".join(f'the plugin "{each.label}" failed in {each.reason}' for each in failures)
            )
        return self

    def last(self, topic: str) -> Any:
        """The newest message of a topic; None if there is none yet.

        Args:
            topic: name of the topic, with or without a leading "/".
        """
        return self.transport.last(topic)

    def send(self, topic: str, message: Any) -> "Harness":
        """Publishes a message, to be received before the next step.

        Args:
            topic: name of the topic, with or without a leading "/".
            message: the message, of the topic's type; see `messages.get`.
        """
        self.transport.send(topic, message)
        return self

    def drive(
        self, forwards: float, turn: float = 0.0, *, left: float = 0.0, topic: str = "/cmd_vel"
    ) -> "Harness":
        """Sends a `geometry_msgs/Twist`.

        Args:
            forwards: velocity [m/s].
            turn: yaw rate [rad/s].
            left: velocity to the left [m/s].
            topic: name of the topic, with or without a leading "/".
        """
        twist = get("geometry_msgs/Twist")()
        twist.linear.x, twist.linear.y, twist.angular.z = forwards, left, turn
        return self.send(topic, twist)

    def record(self, topic: str, seconds: float) -> List[Any]:
        """Advances the time, and returns the messages of a topic meanwhile, at most one a step.

        Args:
            topic: name of the topic, with or without a leading "/".
            seconds: of simulated time.
        """
        messages: List[Any] = []
        before = self.last(topic)
        for _ in range(round(seconds / self.timekeeper.step_size)):
            message = self.run().last(topic)
            if message is not before:
                messages.append(message)
                before = message
        return messages
