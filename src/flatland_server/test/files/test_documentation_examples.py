"""Every YAML example of the documentation loads; every default that it states is what it says.

The examples are copied, with their indentation mended where it is broken, as well as the commas
that are missing in covariance matrices. Plugins that have tests of their own with their issue, and
do not exist before it (Bumper, BoolSensor, TricycleDrive, Tween, Gps), are taken out of the models:
see the plugins page.
"""

import math
import textwrap

import numpy as np
import pytest
import yaml

from flatland_plugins.dynamics_limits import DynamicsLimits
from flatland_plugins.laser import LaserConfig
from flatland_plugins.odometry import OdometryConfig
from flatland_server.collision_filter_registry import ALL_LAYERS
from flatland_server.footprint import Circle, Polygon
from flatland_server.model import ModelConfig
from flatland_server.world import WorldConfig
from flatland_server.yaml_reader import YamlReader

QUICK_START_WORLD = """
properties: {}
layers:
  - name: "map"
    map: "conestogo_office.yaml"
    color: [0.4, 0.4, 0.4, 1]
models:
  - name: turtlebot
    model: "turtlebot.model.yaml"
"""

CONESTOGO_OFFICE = """
image: conestogo_office.png
resolution: 0.050000
origin: [-16.600000, -6.650000, 0.000000]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""

TURTLEBOT = """
bodies:
  - name: base
    pose: [0, 0, 0]
    type: dynamic
    color: [1, 1, 1, 0.4]

    footprints:
      - type: circle
        radius: 0.5
        density: 1

      - type: polygon
        points: [[-.45, -.05], [-.45, 0.05], [-.35, 0.05], [-.35, -0.05]]
        density: 1

      - type: polygon
        points: [[-.125, -.4], [-.125, -.3], [.125, -.3], [.125, -.4]]
        density: 1

      - type: polygon
        points: [[-.125, .4], [-.125, .3], [.125, .3], [.125, .4]]
        density: 1

plugins:
  - type: DiffDrive
    name: turtlebot_drive
    body: base
"""

# The tutorial "Create Model", without its TricycleDrive (plugins page).
CLEANER = """
bodies:
- name: base
  type: dynamic
  color: [1, 1, 1, 0.75]
  footprints:
  - type: polygon
    density: 100
    points: [ [-1.03, -0.337],
              [.07983, -0.337],
              [.30, -.16111],
              [.30, .16111],
              [.07983, 0.337],
              [-1.03, 0.337] ]


- name: front_wheel
  color: [1, 1, 1, 0.75]
  footprints:
  - type: polygon
    density: 1.0
    points: [[ 0.0875, -0.0250],
             [ 0.0875,  0.0250],
             [-0.0875, 0.0250],
             [-0.0875, -0.0250]]

- name: rear_left_wheel
  color: [1, 1, 1, 0.75]
  footprints:
  - type: polygon
    density: 1.0
    points: [[ 0.0875, -0.0255],
             [ 0.0875,  0.0255],
             [-0.0875, 0.0255],
             [-0.0875, -0.0255]]

- name: rear_right_wheel
  color: [1, 1, 1, 0.75]
  footprints:
  - type: polygon
    density: 1.0
    points: [[ 0.0875, -0.0255],
             [ 0.0875,  0.0255],
             [-0.0875, 0.0255],
             [-0.0875, -0.0255]]

joints:
- type: revolute
  name: front_wheel_revolute
  bodies:
  - name: front_wheel
    anchor: [0, 0]
  - name: base
    anchor: [0, 0]

- type: weld
  name: rear_right_wheel_weld
  bodies:
  - name: rear_left_wheel
    anchor: [0, 0]
  - name: base
    anchor: [-0.83, 0.29]

- type: weld
  name: rear_left_wheel_weld
  bodies:
  - name: rear_right_wheel
    anchor: [0, 0]
  - name: base
    anchor: [-0.83, -0.29]

plugins:

- type: ModelTfPublisher
  name: tf_publisher
  publish_tf_world: true

- type: Laser
  name: laser_front
  frame: laser_front
  topic: scan
  body: base
  broadcast_tf: true
  origin: [0.28, 0, 0]
  range: 20
  angle: {min: -2.356194490192345, max: 2.356194490192345, increment: 0.004363323129985824}
  noise_std_dev: 0.05
  update_rate: 40
"""

CUSTOM_ROBOT = """
bodies:
- name: base
  type: dynamic  
  color: [1, 1, 1, 1] 
  footprints:
  - type: polygon
    density: 100
    points: [ [-1.03, -0.337],
              [.07983, -0.337],
              [.30, -.16111],
              [.30, .16111],
              [.07983, 0.337],
              [-1.03, 0.337] ]
"""  # noqa: W291 (as it stands there)

CUSTOM_MODELS = """
models:
- name: your_custom_model
  pose: [0, 0, 0]
  model: "your_custom_model.yaml"
"""

WORLD = """
# required, world properties
properties:

  # optional, defaults to 10, number of velocity iterations for the Box2D
  # physics solver
  velocity_iterations: 10

  # optional, defaults to 10, number of position iterations for the Box2D
  # physics solver
  position_iterations: 10

# required, specifies a list of layers, maximum number of layers is 16,
# constrained by Box2D's collision masks
layers:

    # required, name of the layer, each layer name must be unique
  - name: "layer_1"

    # required, path to the map yaml file, begin with "/" to indicate
    # absolute path, otherwise relative path w.r.t this file is used
    map: "layer_1.yaml"

    # optional, defaults to [1, 1, 1, 1], color for visualization specified
    # by [r, g, b, alpha]
    color: [1, 1, 1, 1]

    # you can also specify a list of names.
  - name: ["layer_2", "layer_3", "layer_4"]
    map: "/absolute/path/layer_2.yaml"

# optional, specifies a list of models to be loaded into the world
models:

    # required, name of the model, must be unique in the world
  - name: turtlebot1

    # optional, defaults to "", specifies the namespace of the robot.
    namespace: ""

    # optional, defaults to [0, 0, 0], pose to put the model, in the format
    # of [position x, position y, angle yaw] in the world coordinate
    pose: [0, 0, 0]

    # required, path to the model yaml file, begin with "/" to indicate
    # absolute path, otherwise relative path w.r.t this file is used
    model: "turtlebot.model.yaml"

  - name: turtlebot12
    namespace: "turtlebot2"
    model: "turtlebot.model.yaml"

  - name: person
    model: "/absolute/path/person.model.yaml"
"""

MAP = """
image: map.png                             # begin with "/" for absolute, otherwise relative
resolution: 0.050000
origin: [-16.600000, -6.650000, 0.000000]
negate: 0                                  # NOT used
occupied_thresh: 0.65
free_thresh: 0.196                         # NOT used
"""

LINE_SEGMENTS = """
type: line_segments        # required for indicating file type is line segments
data: map_lines.dat        # path to line segments data file
scale: 0.1                 # same use as resolution in map server yaml
origin: [-1.20, -5, 1.23]  # same use as origin in map server yaml
"""

LINES = """
0    0    1    1
2    3   -1    2
"""

MODEL = """
bodies:
  - name: base_link
    enabled: true
    pose: [0, 0, 0]
    type: dynamic
    color: [1, 1, 1, 0.5]
    linear_damping: 0
    angular_damping: 0
    footprints:
      - type: circle
        radius: 0.5
        center: [0.0, 0.0]
        layers: ["all"]
        collision: true
        density: 1
        friction: 0
        restitution: 0
        sensor: false


  # body for the rear wheel
  - name: rear_wheel
    footprints:
      - type: polygon
        points: [[-0.05, -0.05], [-0.05, 0.05], [0.05, 0.05], [0.05, -0.05]]
        density: 1

  # body for left wheel
  - name: left_wheel
    footprints:
      - type: polygon
        points: [[-.125, -0.05], [-.125, 0.05], [.125, 0.05], [.125, -0.05]]
        density: 1

  # body for right wheel
  - name: right_wheel
    footprints:
      - type: polygon
        points: [[-.125, -0.05], [-.125, 0.05], [.125, 0.05], [.125, -0.05]]
        density: 1

joints:
  - type: revolute
    name: rear_wheel_revolute
    enabled: true
    collide_connected: false
    limits: [0, 0]
    bodies:
      - name: rear_wheel
        anchor: [0, 0]
      - name: base_link
        anchor: [-0.83, -0.29]

  - type: weld
    name: left_wheel_weld
    angle: 0
    frequency: 0
    damping: 0
    bodies:
      - name: left_wheel
        anchor: [0, 0]
      - name: base_link
        anchor: [-0.83, -0.29]


  - type: weld
    name: right_wheel_weld
    bodies:
      - name: left_wheel
        anchor: [0, 0]
      - name: base_link
        anchor: [-0.83, -0.29]

plugins:
  - type: Laser
    enabled: true
    name: kinect
    body: base_link
    range: 20
    angle: {min: -2.356194490192345, max: 2.356194490192345, increment: 0.004363323129985824}
    noise_std_dev: 0.01
    update_rate: 10


  - type: DiffDrive
    name: turtlebot_drive
    body: base_link
"""

ZEROS = "[" + ",\n                           ".join(["0, 0, 0, 0, 0, 0"] * 6) + "]"

DIFF_DRIVE = f"""
plugins:
  - type: DiffDrive
    name: turtlebot_drive
    body: base
    odom_frame_id: odom
    pub_rate: .inf
    twist_sub: cmd_vel
    odom_pub: odometry/filtered
    ground_truth_pub: odometry/ground_truth
    twist_pub: twist
    enable_odom_pub: true
    enable_twist_pub: true
    odom_pose_noise: [0, 0, 0]
    odom_twist_noise: [0, 0, 0]
    odom_pose_covariance: {ZEROS}
    odom_twist_covariance: {ZEROS}
    angular_dynamics:
      acceleration_limit: 0.0   # max acceleration (away from 0), in rads/s/s
      deceleration_limit: 0.0   # max deceleration (towards 0), in rads/s/s
      velocity_limit: 0.0       # max absolute velocity in rads/s; 0.0 means "no limit"
    linear_dynamics:
      acceleration_limit: 0.0   # max acceleration (away from 0), in m/s/s
      deceleration_limit: 0.0   # max deceleration (towards 0), in m/s/s
      velocity_limit: 0.0       # max absolute velocity in m/s; 0.0 means "no limit"

    ground_truth_frame_id: map  # The name of the ground truth origin TF frame
"""

LASER = """
plugins:
  - type: Laser
    name: laser_back
    topic: scan
    body: base_link
    origin: [0, 0, 0]
    broadcast_tf: true
    frame: laser_back
    range: 20
    noise_std_dev: 0
    angle: {min: -2.356194490192345, max: 2.356194490192345, increment: 0.004363323129985824}
    update_rate: .inf
    layers: ["all"]
    upside_down: false

  # another example
  - type: Laser
    name: laser_front
    body: base_link
    range: 30
    angle: {min: -1.5707963267948966, max: 1.5707963267948966, increment: 1.5707963267948966}
    layers: ["layer_1", "layer_2", "layer_3"]
    update_rate: 100
    noise_std_dev: 0.01
"""

CLOCKWISE_LASER = """
plugins:
  - {type: Laser, name: back, body: base_link, range: 20, angle: {min: 2, max: -2, increment: -0.1}}
"""

MODEL_TF_PUBLISHER = """
plugins:
  - type: ModelTfPublisher
    name: state_publisher
    update_rate: .inf
    publish_tf_world: false
    world_frame_id: map
    reference: base_link
    exclude: []

  # another example
  - type: ModelTfPublisher
    name: state_publisher_2

  # another example
  - type: ModelTfPublisher
    name: state_publisher_3
    exclude: ["castor_wheel"]
"""

PERSON = "bodies: [{name: body, footprints: [{type: circle, radius: 0.2, density: 1}]}]\n"
LEAST_FOOTPRINTS = """
  - {type: circle, radius: 1, density: 1}
  - {type: polygon, points: [[0, 0], [1, 0], [0, 1]], density: 1}
"""
LEAST_ENDS = "[{name: base, anchor: [0, 0]}, {name: wheel, anchor: [0, 0]}]"


def bodies(*names: str) -> str:
    """The bodies that a plugin's example speaks of."""
    disc = "footprints: [{type: circle, radius: 0.2, density: 1}]"
    return "bodies:\n" + "".join(f"  - {{name: {name}, {disc}}}\n" for name in names)


@pytest.fixture
def documented(good_files):
    """A folder with the files that the examples name, and a map image for all of them."""
    image = (good_files.folder / "map.png").read_bytes()
    good_files.write("conestogo_office.png", image)
    good_files.write("map_lines.dat", LINES)
    good_files.write("turtlebot.model.yaml", TURTLEBOT)
    good_files.write("conestogo_office.yaml", CONESTOGO_OFFICE)
    good_files.write("layer_1.yaml", MAP)
    good_files.write("absolute/path/layer_2.yaml", LINE_SEGMENTS)
    good_files.write("absolute/path/map_lines.dat", LINES)
    good_files.write("absolute/path/person.model.yaml", PERSON)
    return good_files


def plugin_reader(files, name: str) -> YamlReader:
    """The entry of a plugin of the model in `plugin.yaml`."""
    config = ModelConfig.from_file(files.folder / "plugin.yaml", None)
    return next(plugin.reader for plugin in config.plugins if plugin.name == name)


def test_the_quick_start_loads_and_drives(documented):
    documented.write("world.yaml", QUICK_START_WORLD)

    world = documented.load()

    assert world.layers[0].name == "map"
    assert world.layers[0].config.color == (0.4, 0.4, 0.4, 1.0)
    assert world.layers[0].segments.min(axis=0)[:2] == pytest.approx((-16.6, -6.65))
    assert len(world.get_model("turtlebot").base.config.footprints) == 4
    assert world.plugin_count == 1


def test_the_world_example_loads(documented):
    documented.write("world.yaml", WORLD.replace("/absolute", f"{documented.folder}/absolute"))

    world = documented.load()

    assert [layer.config.names for layer in world.layers] == [
        ("layer_1",),
        ("layer_2", "layer_3", "layer_4"),
    ]
    assert world.registry.names == ["layer_1", "layer_2", "layer_3", "layer_4"]
    assert world.layers[1].config.bits == 0b1110
    assert {name: model.namespace for name, model in world.models.items()} == {
        "turtlebot1": "",
        "turtlebot12": "turtlebot2",
        "person": "",
    }


def test_the_map_example_loads(documented):
    documented.write("world.yaml", "{properties: {}, layers: [{name: map, map: layer_1.yaml}]}")

    segments = documented.load().layers[0].segments

    # 40 pixels of 5 cm, from the origin on.
    assert segments.reshape(-1, 2).min(axis=0) == pytest.approx((-16.6, -6.65))
    assert segments.reshape(-1, 2).max(axis=0) == pytest.approx((-14.6, -4.65))


def test_the_line_segments_example_loads(documented):
    documented.write("lines.yaml", LINE_SEGMENTS)
    documented.write("world.yaml", "{properties: {}, layers: [{name: map, map: lines.yaml}]}")

    segments = documented.load().layers[0].segments

    cos, sin = math.cos(1.23), math.sin(1.23)
    points = [(0, 0), (1, 1), (2, 3), (-1, 2)]
    placed = [(-1.2 + 0.1 * (cos * x - sin * y), -5 + 0.1 * (sin * x + cos * y)) for x, y in points]
    assert segments.reshape(-1, 2) == pytest.approx(np.array(placed))


def test_the_model_example_loads(documented):
    robot = documented.spawn(MODEL).get_model("robot")

    assert list(robot.bodies) == ["base_link", "rear_wheel", "left_wheel", "right_wheel"]
    assert [(joint.name, joint.config.type) for joint in robot.joints] == [
        ("rear_wheel_revolute", "revolute"),
        ("left_wheel_weld", "weld"),
        ("right_wheel_weld", "weld"),
    ]
    assert robot.joints[0].config.limits == (0.0, 0.0)
    assert robot.joints[0].config.bodies == ("rear_wheel", "base_link")
    assert robot.joints[0].config.anchors == ((0.0, 0.0), (-0.83, -0.29))


def test_the_model_tutorial_loads(documented):
    robot = documented.spawn(CLEANER).get_model("robot")

    assert list(robot.bodies) == ["base", "front_wheel", "rear_left_wheel", "rear_right_wheel"]
    assert len(robot.joints) == 3
    assert len(robot.base.config.footprints[0].shape.vertices) == 6


def test_the_custom_robot_tutorial_loads(documented):
    documented.write("your_custom_model.yaml", CUSTOM_ROBOT)
    documented.write("world.yaml", f"properties: {{}}\nlayers: []\n{CUSTOM_MODELS}")

    robot = documented.load().get_model("your_custom_model")

    assert robot.base.config.color == (1.0, 1.0, 1.0, 1.0)
    assert robot.base.config.footprints[0].density == 100.0


@pytest.mark.parametrize(
    ("names", "example", "count"),
    [
        (("base",), DIFF_DRIVE, 1),
        (("base_link",), CLOCKWISE_LASER, 1),
        (("base_link", "castor_wheel"), MODEL_TF_PUBLISHER, 3),
    ],
    ids=["DiffDrive", "Laser, clockwise", "ModelTfPublisher"],
)
def test_a_plugins_example_loads(documented, names, example, count):
    world = documented.spawn(bodies(*names) + textwrap.dedent(example))

    assert world.plugin_count == count


def test_the_lasers_example_loads_where_its_layers_are(documented):
    documented.write("laser.yaml", bodies("base_link") + LASER)
    documented.write(
        "world.yaml",
        """
        properties: {}
        layers: [{name: [layer_1, layer_2, layer_3]}]
        models: [{name: robot, model: laser.yaml}]
        """,
    )

    assert documented.load().plugin_count == 2


# Defaults


def test_the_worlds_defaults(documented):
    documented.write(
        "world.yaml",
        """
        properties: {}
        layers: [{name: layer_1, map: layer_1.yaml}]
        models: [{name: turtlebot, model: turtlebot.model.yaml}]
        """,
    )

    config = WorldConfig.from_file(documented.folder / "world.yaml")

    assert (config.velocity_iterations, config.position_iterations) == (10, 10)
    assert config.layers[0].color == (1.0, 1.0, 1.0, 1.0)
    assert config.models[0].namespace == ""
    assert config.models[0].pose == (0.0, 0.0, 0.0)
    assert config.plugins == ()


def test_models_are_optional(documented):
    documented.write("world.yaml", "{properties: {}, layers: [{name: map, map: layer_1.yaml}]}")

    assert WorldConfig.from_file(documented.folder / "world.yaml").models == ()


def test_the_models_defaults(documented):
    documented.write(
        "plugin.yaml",
        f"""
bodies:
  - name: base
    footprints: {textwrap.indent(LEAST_FOOTPRINTS, "    ")}
  - name: wheel
    footprints: []
joints:
  - {{name: r, type: revolute, bodies: {LEAST_ENDS}}}
  - {{name: w, type: weld, bodies: {LEAST_ENDS}}}
""",
    )

    model = ModelConfig.from_file(documented.folder / "plugin.yaml", None)

    body = model.bodies[0]
    assert body.pose == (0.0, 0.0, 0.0)
    assert body.type == "dynamic"
    assert body.color == (1.0, 1.0, 1.0, 0.5)
    assert (body.linear_damping, body.angular_damping) == (0.0, 0.0)
    circle, polygon = body.footprints
    assert circle.shape == Circle((0.0, 0.0), 1.0)
    assert polygon.shape == Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    for footprint in body.footprints:
        assert footprint.layers == ("all",)
        assert footprint.layer_bits == ALL_LAYERS
        assert footprint.collision is True
        assert footprint.sensor is False
        assert (footprint.friction, footprint.restitution) == (0.0, 0.0)
    hinge, weld = model.joints
    for joint in model.joints:
        assert joint.collide_connected is False
    assert hinge.limits is None
    assert (weld.angle, weld.frequency, weld.damping) == (0.0, 0.0, 0.0)
    assert model.plugins == ()


def test_joints_and_plugins_are_optional(documented):
    documented.write("plugin.yaml", PERSON)

    model = ModelConfig.from_file(documented.folder / "plugin.yaml", None)

    assert (model.joints, model.plugins) == ((), ())


@pytest.mark.parametrize("section", ["bodies", "joints", "plugins"])
def test_what_is_listed_is_enabled_by_default(documented, section):
    documented.write("model.yaml", MODEL)
    given = [entry["name"] for entry in yaml.safe_load(MODEL)[section]]
    model = ModelConfig.from_file(documented.folder / "model.yaml", None)

    assert [entry.name for entry in getattr(model, section)] == given


def test_the_diff_drives_defaults(documented):
    documented.write(
        "plugin.yaml",
        bodies("base") + "plugins: [{type: DiffDrive, name: least, body: base}]\n",
    )
    least = plugin_reader(documented, "least")
    documented.write("plugin.yaml", bodies("base") + DIFF_DRIVE)
    example = plugin_reader(documented, "turtlebot_drive")

    assert OdometryConfig.read(least) == OdometryConfig.read(example)
    for reader in (least, example):
        assert DynamicsLimits.read(reader, "linear_dynamics") == (0.0, 0.0, 0.0)
        assert DynamicsLimits.read(reader, "angular_dynamics") == (0.0, 0.0, 0.0)
        assert reader.get_rate("pub_rate", math.inf) == math.inf
        assert reader.get_string("twist_sub", "cmd_vel") == "cmd_vel"


def test_covariances_have_the_noise_on_their_diagonals_by_default(documented):
    documented.write(
        "plugin.yaml",
        bodies("base")
        + "plugins: [{type: DiffDrive, name: drive, body: base, odom_pose_noise: [1, 2, 3], "
        "odom_twist_noise: [4, 5, 6]}]\n",
    )

    config = OdometryConfig.read(plugin_reader(documented, "drive"))

    pose, twist = (
        np.reshape(matrix, (6, 6)) for matrix in (config.pose_covariance, config.twist_covariance)
    )
    assert (pose == np.diag([1, 2, 0, 0, 0, 3])).all()
    assert (twist == np.diag([4, 5, 0, 0, 0, 6])).all()


def test_the_deceleration_limit_is_the_acceleration_limit_by_default(documented):
    documented.write(
        "plugin.yaml",
        bodies("base") + "plugins: [{type: DiffDrive, name: drive, body: base, "
        "linear_dynamics: {acceleration_limit: 2}}]\n",
    )

    limits = DynamicsLimits.read(plugin_reader(documented, "drive"), "linear_dynamics")

    assert limits == (2.0, 2.0, 0.0)


def test_the_lasers_defaults(documented):
    documented.write(
        "plugin.yaml",
        bodies("base") + "plugins: [{type: Laser, name: laser_back, body: base, range: 20, "
        "angle: {min: -1, max: 1, increment: 0.5}}]\n",
    )
    reader = plugin_reader(documented, "laser_back")
    reader.get_string("body")

    laser = LaserConfig.read(reader, "laser_back")

    assert laser.topic == "scan"
    assert laser.origin == (0.0, 0.0, 0.0)
    assert laser.broadcast_tf is True
    assert laser.frame == "laser_back"
    assert laser.noise_std_dev == 0.0
    assert laser.update_rate == math.inf
    assert laser.layers == ("all",)
    assert laser.upside_down is False
    assert laser.beams == 5


def test_the_model_tf_publishers_defaults(documented):
    world = documented.spawn(
        bodies("base_link", "castor_wheel")
        + "plugins: [{type: ModelTfPublisher, name: state_publisher}]\n"
    )
    plugin = world._plugins.plugins_of("robot")[0]

    # The first body is the reference, nothing is excluded, and the world's frame is not published.
    assert plugin._reference.name == "base_link"
    assert [body.name for body in plugin._bodies] == ["castor_wheel"]
    assert plugin._publish_tf_world is False
    assert plugin._world_frame_id == "map"
    assert plugin.update_timer.period == 0.0
