"""Random messages to all topics of plugins: no plugin fails, and all poses stay finite."""

import math
import random
from pathlib import Path
from typing import Any, Callable, Dict, List

import numpy as np
import roslib.message
from genpy import Duration, Message, Time
from soak.corpus import Corpus
from soak.findings import Findings

from flatland_server import LocalTransport, Subscription, World
from flatland_server.geometry import Pose
from flatland_server.testing import Harness

FLOATS = (
    *(0.0, -0.0, 1.0, -1.0, 0.5, 3.0, 1e-9, 5e-324, 1e6, -1e6, 1e30, 1e38, -1e38),
    *(math.nan, math.inf, -math.inf),
)
INTEGERS = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
    **{"byte": (-128, 127), "char": (0, 255)},
}
WORDS = ("", "robot", "base", "map", "a b", "/", "//", "~", "\x00", "ü", "x" * 3000, "odom")


def random_message(type_name: str, rng: random.Random) -> Any:
    """A message with random fields, such as "geometry_msgs/Twist"; a third of them is empty."""
    message = roslib.message.get_message_class(type_name)()
    if rng.random() < 0.3:
        return message
    for field, field_type in zip(message.__slots__, message._slot_types):
        setattr(message, field, _random_value(field_type, rng))
    return message


def _random_value(field_type: str, rng: random.Random) -> Any:
    element, bracket, size = field_type.partition("[")
    if bracket:
        count = int(size[:-1]) if size != "]" else rng.choice([0, 1, 2, 40])
        if element in ("uint8", "char"):
            return bytes(rng.randrange(256) for _ in range(count))
        return [_random_value(element, rng) for _ in range(count)]
    if element.startswith("float"):
        usual = rng.uniform(-3, 3)
        value = rng.choice([usual, *FLOATS]) if rng.random() < 0.6 else usual
        # Beyond a float32, what is huge is infinite.
        return value if element == "float64" else float(np.float32(value))
    if element == "string":
        return rng.choice(WORDS)
    if element in ("time", "duration"):
        return (Time if element == "time" else Duration)(rng.randrange(2**31), rng.randrange(10**9))
    if element == "bool":
        return rng.random() < 0.5
    if element in INTEGERS:
        low, high = INTEGERS[element]
        return rng.choice([0, 1, 2, low, high, rng.randint(low, high)])
    return random_message(element, rng)


class TypedTransport(LocalTransport):
    """Knows the types of the topics that are subscribed to."""

    def __init__(self) -> None:
        super().__init__()
        self.types: Dict[str, str] = {}

    def subscribe(
        self, topic: str, message_type: Any, callback: Callable[[Any], None]
    ) -> Subscription:
        self.types[topic if topic.startswith("/") else f"/{topic}"] = message_type._type
        return super().subscribe(topic, message_type, callback)


def every_model(corpus: Corpus) -> Harness:
    """A world with all models of the corpus that can be spawned together."""
    world = World.from_file(corpus.folder / "plugins" / "world.yaml", TypedTransport())
    for number, path in enumerate(corpus.models):
        if path.parts[-2] in ("plugins", "office"):
            name = f"m{number}"
            world.spawn_model(path, name, name, Pose(3.0 * number, 30.0, 0.0))
    return Harness(world, allow_failures=True)


def unusual_poses(world: World) -> List[str]:
    """The bodies that are not at finite poses with finite velocities."""
    return [
        f"{model.name}: {[*body.pose, *body.velocity]}"
        for model in world.models.values()
        for body in model.physics_bodies
        if not np.all(np.isfinite([*body.pose, *body.velocity]))
    ]


def send_random_messages(folder: Path, seed: int, steps: int, findings: Findings) -> None:
    """Steps a world of all models, with random messages between the steps."""
    rng = random.Random(f"messages {seed}")
    simulation = every_model(Corpus.copy_to(folder))
    world, transport = simulation.world, simulation.transport
    findings.expect(len(transport.subscribed) > 3, f"too few topics: {transport.subscribed}")
    for step in range(steps):
        for topic in sorted(transport.subscribed):
            if rng.random() < 0.5:
                message = random_message(transport.types[topic], rng)
                simulation.send(topic, message)
                findings.counts["messages in process"] += 1
        simulation.run()
        bad = unusual_poses(world)
        if not findings.expect(not bad, f"seed {seed}, step {step}: {bad}"):
            break
    for failure in world.plugin_failures:
        findings.expect(False, f"seed {seed}: {failure.label} failed in {failure.reason}")
    frames = [t for t in transport.transforms.values() if not is_finite(t)]
    findings.expect(not frames, f"seed {seed}: transforms {frames[:3]}")
    world.close()


def is_finite(value: Any) -> bool:
    """True if all numbers in a message or a value are finite."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, Message):
        return all(is_finite(getattr(value, field)) for field in value.__slots__)
    if isinstance(value, (list, tuple)):
        return all(is_finite(each) for each in value)
    return not hasattr(value, "__dict__") or all(is_finite(v) for v in vars(value).values())
