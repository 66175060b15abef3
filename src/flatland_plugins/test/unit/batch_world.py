"""A world for batches: a robot among walls and boxes, and a door that a tween moves."""

from pathlib import Path

from flatland_server.testing import WorldFiles

LASER = """{type: Laser, name: laser, body: base, range: 6, origin: [0.1, 0.02, 0.1],
 angle: {min: -2, max: 2, increment: 0.05}, noise_std_dev: NOISE}"""
DRIVES = {
    "DiffDrive": """{type: DiffDrive, name: drive, body: base, odom_drift: [.1, .1, .1],
 linear_dynamics: {acceleration_limit: 2, velocity_limit: 1.5}}""",
    "AckermannDrive": """{type: AckermannDrive, name: drive, body: base, wheelbase: 0.3,
 max_steer_angle: 0.5, jerk_limit: 20, linear_dynamics: {acceleration_limit: 4},
 angular_dynamics: {velocity_limit: 2}, front_left_wheel_joint: steered, single_track: {mass: 3,
 inertia: 0.05, center_of_mass: 0.16, height: 0.05, friction: 1, front_stiffness: 4,
 rear_stiffness: 5}}""",
    "OmniDrive": "{type: OmniDrive, name: drive, body: base}",
    "TricycleDrive": """{type: TricycleDrive, name: drive, body: base, max_steer_angle: 0.7,
 front_wheel_joint: front, rear_left_wheel_joint: left, rear_right_wheel_joint: right}""",
}
ROBOT = """
bodies:
  - {name: base, pose: [0.05, 0, 0.2],
     footprints: [{type: circle, radius: 0.25, center: [-0.1, 0], density: 5, friction: 0.4}]}
  - {name: front, pose: [0.05, 0, 0.2], footprints: [WHEEL]}
  - {name: steered, pose: [0.35, 0.06, 0.2], footprints: [WHEEL]}
  - {name: left, pose: [-0.25, 0.1, 0.2], footprints: [WHEEL]}
  - {name: right, pose: [-0.2, -0.2, 0.2], footprints: [WHEEL]}
joints:
  - {type: revolute, name: front, bodies: [{name: base, anchor: [0, 0]},
     {name: front, anchor: [0, 0]}]}
  - {type: revolute, name: steered, bodies: [{name: base, anchor: [0.3, 0]},
     {name: steered, anchor: [0, 0]}]}
  - {type: weld, name: left, bodies: [{name: base, anchor: [-0.3, 0.15]},
     {name: left, anchor: [0, 0]}]}
  - {type: weld, name: right, bodies: [{name: base, anchor: [-0.3, -0.15]},
     {name: right, anchor: [0, 0]}]}
plugins:
  - DRIVE
  - LASER
  - {type: Bumper, name: bumper}
  - {type: ModelTfPublisher, name: tf}
""".replace("WHEEL", "{type: circle, radius: 0.05, density: 1, layers: []}")
BOX = """
bodies:
  - name: base
    footprints: [{type: polygon, points: [[-.2, -.2], [.2, -.2], [.2, .2], [-.2, .2]], density: 3,
      friction: 0.6, restitution: 0.2}]
    linear_damping: 1
"""
DOOR = """
bodies:
  - {name: door, type: kinematic,
     footprints: [{type: polygon, points: [[-.6, -.1], [.6, -.1], [.6, .1], [-.6, .1]],
       density: 1}]}
plugins: [{type: Tween, name: tween, body: door, delta: [0.5, 1, 1], duration: 1.3}]
"""
WALKER = """
bodies:
  - {name: body, footprints: [{type: circle, radius: 0.25, density: 400}]}
  - {name: left_leg, footprints: [LEG]}
  - {name: right_leg, footprints: [LEG]}
  - {name: circle, footprints: [LEG]}
plugins:
  - {type: Pedestrian, name: walk, goals: [[2, 0.5], [-2, 0]], layers: [map], update_rate: 11,
     safety_dist_body: circle, var_leg_offset: 0.05, step_time: 0.5}
""".replace("LEG", "{type: circle, radius: 0.08, density: 1, collision: false}")
RECORDING = """frame,id,x,y
0,1,-2.5,-2
10,1,-1.5,-2
20,1,-0.5,-2.5
5,2,2.2,2.5
15,2,2.2,0
60,7,2,-2
70,7,2,-1
"""
"""In which two bodies show three people."""
WALLS = ("-3 -3 3 -3", "3 -3 3 3", "3 3 -3 3", "-3 3 -3 -3", "-1 2 1 2", "1 1 1 2", "1 1 2.5 1")
WORLD = """
properties: {}
layers: [{name: map, map: MAP}]
models:
  - {name: box1, model: box.yaml, pose: [1, -1, 0.3]}
  - {name: robot, model: robot.yaml, pose: [-1, 0, 0]}
  - {name: box2, model: box.yaml, pose: [0, 0.1, 0]}
  - {name: box3, model: box.yaml, pose: [0, -0.35, 0]}
  - {name: door, model: door.yaml, pose: [0, -2, 0]}
"""


def write_world(folder: Path, drive="DiffDrive", noise="0", models=WORLD, others="") -> Path:
    """Writes the world's files; returns that of the world.

    Args:
        folder: folder to write the files to.
        drive: of the robot: a key of `DRIVES`.
        noise: of the lidar [m].
        models: the content of the world file.
        others: more plugins of the robot.
    """
    files = WorldFiles(folder)
    plugins = ROBOT.replace("DRIVE", DRIVES[drive] + others)
    files.write("robot.yaml", plugins.replace("LASER", LASER.replace("NOISE", noise)))
    files.write("box.yaml", BOX)
    files.write("door.yaml", DOOR)
    files.write("walker.yaml", WALKER)
    files.write("people.csv", RECORDING)
    return files.write("world.yaml", models.replace("MAP", files.walls("map", *WALLS)))
