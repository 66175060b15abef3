"""A world that changes everything a saved state has to keep, and digests of its messages.

Run as a program, `busy_town.py FOLDER SECONDS [STATE]`, it prints the digest of a run in a process
of its own, from the beginning or from a saved state.
"""

import hashlib
import math
import sys
from pathlib import Path
from typing import Any, Container, Dict, List, Optional, Tuple

from flatland_server import LocalTransport, Pose, World, messages
from flatland_server.testing import Harness, WorldFiles
from flatland_server.testing.observation import content_of

Bool = messages.get("std_msgs/Bool")

NOISE = "odom_pose_noise: [.01, .01, .01], odom_twist_noise: [.01, .01, .01]"
DISC = "{type: circle, radius: 0.2, density: 5, friction: 0.5, restitution: 0.3}"
ROBOT = f"""
bodies:
  - {{name: base, footprints: [{DISC}]}}
  - name: bumper
    pose: [0.25, 0, 0]
    footprints: [{{type: polygon, points: [[0, -.1], [.05, -.1], [.05, .1], [0, .1]], density: 1}}]
joints:
  - {{type: weld, name: mount, bodies: [{{name: base, anchor: [.25, 0]}},
     {{name: bumper, anchor: [0, 0]}}]}}
plugins:
  - {{type: DiffDrive, name: drive, body: base, pub_rate: 70, {NOISE}, odom_drift: [.1, .1, .1],
     linear_dynamics: {{acceleration_limit: 1.0}}, angular_dynamics: {{acceleration_limit: 2.0}}}}
  - {{type: Laser, name: laser, body: base, range: 8, noise_std_dev: 0.02, update_rate: 30,
     angle: {{min: -2, max: 2, increment: 0.1}}}}
  - {{type: Imu, name: imu, body: base, pub_rate: 60, angular_velocity_noise: [.1, .1, .1]}}
  - {{type: Bumper, name: bumper, update_rate: 20}}
  - {{type: BoolSensor, name: touch, body: bumper, update_rate: 15}}
  - {{type: ModelTfPublisher, name: tf, update_rate: 25}}
  - {{type: Gps, name: gps, body: base, update_rate: 10}}
"""
BOX = """
bodies:
  - name: base
    footprints:
      - {type: polygon, points: [[-.2, -.2], [.2, -.2], [.2, .2], [-.2, .2]], density: 3,
         friction: 0.6, restitution: 0.2}
    linear_damping: 1.0
    angular_damping: 1.0
plugins:
  - {type: Bumper, name: bumper, world_frame_id: map}
  - {type: BoolSensor, name: touch}
"""
DOOR = """
bodies:
  - name: door
    type: kinematic
    footprints: [{type: polygon, points: [[-.6, -.1], [.6, -.1], [.6, .1], [-.6, .1]], density: 1}]
plugins:
  - {type: Tween, name: tween, body: door, delta: [1.5, 0, 1], duration: 2.3, mode: trigger,
     easing: cubicInOut}
"""
WALKER = """
bodies:
  - {name: body, footprints: [{type: circle, radius: 0.25, density: 400}]}
  - {name: left_leg, footprints: [LEG]}
  - {name: right_leg, footprints: [LEG]}
plugins:
  - {type: Pedestrian, name: walk, goals: [[-3, 1], [3, 1]], swing_radius: 0.05}
  - {type: PosePublisher, name: pose, update_rate: 15}
""".replace("LEG", "{type: circle, radius: 0.08, density: 1, collision: false}")
WALLS = ("-4 -4 4 -4", "4 -4 4 4", "4 4 -4 4", "-4 4 -4 -4", "-1 2 1 2", "-3 -1 -3 1")
WORLD = """
properties: {}
layers: [{name: map, map: MAP}]
models:
  - {name: anna, namespace: anna, model: robot.yaml, pose: [-1, 0, 0]}
  - {name: bert, namespace: bert, model: robot.yaml, pose: [1, 0, 3.1]}
  - {name: box1, namespace: box1, model: box.yaml, pose: [0, 0, 0.3]}
  - {name: box2, namespace: box2, model: box.yaml, pose: [0.1, 0.6, 0]}
  - {name: rests1, namespace: rests1, model: box.yaml, pose: [-3.3, 3.2, 0]}
  - {name: rests2, namespace: rests2, model: box.yaml, pose: [-2.9, 3.2, 0]}
  - {name: gone, namespace: gone, model: box.yaml, pose: [3, 3, 0]}
  - {name: door, model: door.yaml, pose: [0, -2, 0]}
  - {name: walker, namespace: walker, model: walker.yaml, pose: [2, 1.2, 0]}
plugins:
  - {type: RandomWall, name: walls, layer: map, num_of_walls: 2, wall_wall_dist: 0.5,
     robot_name: anna}
  - type: Crowd
    name: crowd
    update_rate: 20
    legs: true
    pedestrians:
      - {name: carl, pose: [-2, -2, 0], goals: [[-1.4, -2], [2, -2]]}
      - {name: dora, pose: [2, -1, 0], goals: [[-2, 0], [2, 0]]}
      - {name: emil, pose: [2.5, 2.5, 0], goals: [[-2, -2], [2.5, 2.5]]}
"""


class Recorder(LocalTransport):
    """Digests all messages, with their topics, and all transforms."""

    def __init__(self, subscribed_topics: Optional[Container[str]] = None) -> None:
        super().__init__(subscribed_topics=subscribed_topics)
        self.restart()

    def restart(self) -> None:
        """Begins a new digest."""
        self.digest = hashlib.sha256()
        self.count = 0

    def record(self, *what: Any) -> None:
        """Adds a message or a transform."""
        self.count += 1
        self.digest.update(repr(what).encode())

    def advertise(self, topic: str, message_type: Any, **options: Any) -> Any:
        publisher = super().advertise(topic, message_type, **options)
        publish = publisher.publish

        def record_and_publish(message: Any) -> None:
            self.record(topic, content_of(message))
            publish(message)

        publisher.publish = record_and_publish
        return publisher

    def send_transform(self, transform: Any) -> None:
        self.record(transform)
        super().send_transform(transform)


class Town:
    """The world, and a timetable of events in it."""

    def __init__(
        self, folder: Path, seed: int = 4, subscribed_topics: Optional[Container[str]] = None
    ) -> None:
        self.files = WorldFiles(folder)
        self.files.write("robot.yaml", ROBOT)
        self.files.write("box.yaml", BOX)
        self.files.write("door.yaml", DOOR)
        self.files.write("walker.yaml", WALKER)
        world = WORLD.replace("MAP", self.files.walls("map", *WALLS))
        self.transport = Recorder(subscribed_topics)
        path = self.files.write("world.yaml", world)
        loaded = World.from_file(path, self.transport, seed=seed, loader=self.files.loader)
        self.simulation = Harness(loaded)
        self.started: List[int] = []

    def run(self, seconds: float) -> "Town":
        """Advances the time, with commands that depend on the time alone."""
        for _ in range(round(seconds / 0.005)):
            self.act()
            self.simulation.run()
        return self

    def act(self) -> None:
        """Runs the events before the next step; only every tenth step has some."""
        world = self.simulation.world
        step = self.simulation.timekeeper.nanoseconds // 5_000_000
        if step % 40 == 0:
            for index, robot in enumerate(("anna", "bert", "late")):
                if robot in world.models:
                    speed, turn = math.sin(0.013 * step + index), math.cos(0.7 * step)
                    self.simulation.drive(speed, turn, topic=f"/{robot}/cmd_vel")
            self.simulation.send("/tween_trigger", Bool(step % 240 < 160))
        if step == 100:
            world.delete_model("gone")
            world.spawn_model(self.files.folder / "robot.yaml", "late", "late", Pose(-2, 2, 0))
        if step == 150:
            world.add_walls("map", [[1.0, 1.0, 2.0, 1.5]])
            world.spawn_model(self.files.folder / "box.yaml", "gone", "gone", Pose(3, -3, 1))
            world.delete_model("emil")
        if step == 220:
            world.move_model("bert", Pose(1.5, -1.0, 2.0))

    def motion(self) -> Dict[str, List[Tuple[float, ...]]]:
        """Pose and velocity of each body, by model."""
        return {
            name: [
                (*body.physics_body.pose, *body.physics_body.velocity)
                for body in model.bodies.values()
            ]
            for name, model in self.simulation.world.models.items()
        }

    def digest(self, seconds: float) -> str:
        """Advances the time; returns a digest of its messages, transforms, poses and walls."""
        self.transport.restart()
        self.run(seconds)
        world = self.simulation.world
        self.transport.record(self.motion())
        self.transport.record([layer.segments.tolist() for layer in world.layers])
        assert self.transport.count > 100 * seconds
        return self.transport.digest.hexdigest()


if __name__ == "__main__":
    if len(sys.argv) > 3:
        town = Town(Path(sys.argv[1]), seed=99)
        town.simulation.load_state(Path(sys.argv[3]).read_bytes())
    else:
        town = Town(Path(sys.argv[1]))
    print(town.digest(float(sys.argv[2])))
