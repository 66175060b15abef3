"""A misspelt key of a built-in plugin, at any depth, is refused with its line and a suggestion."""

import textwrap
from typing import Iterator, List, NamedTuple

import pytest
import yaml

ODOMETRY = """
    body: base
    pub_rate: 10
    twist_sub: cmd_vel
    odom_frame_id: odom
    ground_truth_frame_id: map
    odom_pub: odometry/filtered
    ground_truth_pub: odometry/ground_truth
    twist_pub: twist
    enable_odom_pub: true
    enable_twist_pub: true
    enable_odom_tf_pub: true
    twist_in_local_frame: true
    odom_pose_noise: [0, 0, 0]
    odom_twist_noise: [0, 0, 0]
    odom_drift: [0, 0, 0]
    odom_pose_covariance: &matrix [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                   0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]
    odom_twist_covariance: *matrix
    linear_dynamics:
      acceleration_limit: 1
      deceleration_limit: 1
      velocity_limit: 1
    angular_dynamics:
      acceleration_limit: 1
      deceleration_limit: 1
      velocity_limit: 1
"""

MODEL_PLUGINS = {
    "BoolSensor": """
        topic: bool_sensor
        body: base
        update_rate: 10
        """,
    "Bumper": """
        world_frame_id: map
        topic: collisions
        update_rate: 10
        publish_all_collisions: true
        exclude: [front]
        """,
    "DiffDrive": ODOMETRY,
    "Gps": """
        body: base
        topic: gps/fix
        update_rate: 10
        broadcast_tf: true
        frame: gps
        ref_lat: 0
        ref_lon: 0
        origin: [0, 0, 0]
        """,
    "Imu": """
        body: base
        enable_imu_pub: true
        imu_frame_id: imu
        imu_pub: imu/filtered
        ground_truth_pub: imu/ground_truth
        orientation_noise: [0, 0, 0]
        angular_velocity_noise: [0, 0, 0]
        linear_acceleration_noise: [0, 0, 0]
        orientation_covariance: [0, 0, 0, 0, 0, 0, 0, 0, 0]
        angular_velocity_covariance: [0, 0, 0, 0, 0, 0, 0, 0, 0]
        linear_acceleration_covariance: [0, 0, 0, 0, 0, 0, 0, 0, 0]
        gravity: 9.81
        pub_rate: 10
        broadcast_tf: true
        """,
    "Laser": """
        body: base
        topic: scan
        frame: laser
        broadcast_tf: true
        origin: [0, 0, 0]
        range: 10
        noise_std_dev: 0
        update_rate: 10
        layers: [map]
        upside_down: false
        always_publish: false
        angle:
          min: -1
          max: 1
          increment: 0.1
        """,
    "ModelTfPublisher": """
        reference: base
        publish_tf_world: true
        world_frame_id: map
        update_rate: 10
        exclude: [front]
        """,
    "OmniDrive": ODOMETRY,
    "TricycleDrive": ODOMETRY
    + """
    front_wheel_joint: hinge
    rear_left_wheel_joint: left_hub
    rear_right_wheel_joint: right_hub
    max_steer_angle: 0
    max_angular_velocity: 0
    max_steer_acceleration: 0
""",
    "Tween": """
        body: base
        mode: yoyo
        easing: linear
        trigger_topic: tween_trigger
        duration: 1
        delta: [1, 0, 0]
        """,
}
WORLD_PLUGINS = {
    "Crowd": """
        update_rate: 20
        layers: [map]
        goal_radius: 0.3
        poses_pub: crowd/poses
        world_frame_id: map
        speed: 1.3
        radius: 0.25
        legs: true
        color: [1, 1, 1, 1]
        force:
          relaxation_time: 0.5
          repulsion: 2
          range: 0.3
          evasion: 1
          side: right
          noise: 0.1
        pedestrians:
          - pose: [3, 3, 0]
            name: anna
            goals: [[4, 4]]
            speed: 1.3
            radius: 0.25
            legs: true
            color: [1, 1, 1, 1]
        """,
    "RandomWall": """
        layer: map
        num_of_walls: 1
        wall_wall_dist: 1
        double_wall: false
        robot_name: robot
        """,
}
"""All keys of each plugin; of the two that the rate of Imu has, one."""

FILES = {
    "lines.yaml": "{type: line_segments, data: lines.dat, scale: 1, origin: [0, 0, 0]}",
    "lines.dat": "-9 9 9 9",
    "world.yaml": """\
properties: {}
layers: [{name: map, map: lines.yaml}]
models: [{name: robot, model: robot.model.yaml}]
""",
    "robot.model.yaml": """\
bodies:
  - {name: base, footprints: [{type: circle, radius: 0.1, density: 1}]}
  - {name: front, footprints: []}
  - {name: left, footprints: []}
  - {name: right, footprints: []}
joints:
  - type: revolute
    name: hinge
    bodies: [{name: front, anchor: [0, 0]}, {name: base, anchor: [0, 0]}]
  - type: weld
    name: left_hub
    bodies: [{name: left, anchor: [0, 0]}, {name: base, anchor: [-1, 0.3]}]
  - type: weld
    name: right_hub
    bodies: [{name: right, anchor: [0, 0]}, {name: base, anchor: [-1, -0.3]}]
""",
}
"""A world and a robot; the plugin comes at the end of one of the two files."""


def file_of(plugin: str) -> str:
    return "world.yaml" if plugin in WORLD_PLUGINS else "robot.model.yaml"


def text_of(plugin: str) -> str:
    """The file that the plugin is in."""
    keys = textwrap.dedent({**MODEL_PLUGINS, **WORLD_PLUGINS}[plugin]).strip("\n")
    head = f"plugins:\n  - type: {plugin}\n    name: it\n    enabled: true\n"
    entry = head + textwrap.indent(keys, "    ")
    return FILES[file_of(plugin)] + entry + "\n"


class Key(NamedTuple):
    """A key of a plugin, and where it is in the text."""

    name: str
    section: str
    line: int
    start: int

    @property
    def path(self) -> str:
        return f"{self.section.partition(' ')[0]}.{self.name}"


def keys_within(section: yaml.MappingNode, path: str) -> Iterator[Key]:
    """The keys of a mapping and of what is in it."""
    for key, value in section.value:
        yield Key(key.value, path, key.start_mark.line + 1, key.start_mark.index)
        within = f"{path.partition(' ')[0]}.{key.value}"
        if isinstance(value, yaml.MappingNode):
            yield from keys_within(value, within)
        elif isinstance(value, yaml.SequenceNode):
            for index, item in enumerate(value.value):
                if isinstance(item, yaml.MappingNode):
                    names = [v.value for k, v in item.value if k.value == "name"]
                    yield from keys_within(item, f'{within}[{index}] "{names[0]}"')


def keys_of(plugin: str) -> List[Key]:
    """All but its type and name, without which it is not even looked at."""
    document = yaml.compose(text_of(plugin))
    [plugins] = [value for key, value in document.value if key.value == "plugins"]
    keys = keys_within(plugins.value[0], 'plugins[0] "it"')
    return [key for key in keys if key.path not in ("plugins[0].type", "plugins[0].name")]


CASES = [
    pytest.param(plugin, key, id=key.path.replace("plugins[0]", plugin))
    for plugin in (*MODEL_PLUGINS, *WORLD_PLUGINS)
    for key in keys_of(plugin)
]


@pytest.fixture
def written(files):
    """A folder with the world and the robot."""
    for name, text in FILES.items():
        files.write(name, text)
    return files


def test_no_built_in_plugin_is_left_out(files):
    declared = {declaration.name for declaration in files.declarations}

    assert declared == {*MODEL_PLUGINS, *WORLD_PLUGINS}


@pytest.mark.parametrize("plugin", [*MODEL_PLUGINS, *WORLD_PLUGINS])
def test_without_a_mistake_the_plugin_is_loaded(written, plugin):
    written.write(file_of(plugin), text_of(plugin))

    world = written.load()

    assert world.plugin_count == 1
    world.close()


@pytest.mark.parametrize(("plugin", "key"), CASES)
def test_a_misspelt_key_is_refused_with_its_line_and_a_suggestion(written, plugin: str, key: Key):
    text, name = text_of(plugin), key.name
    misspelt = name[1] + name[0] + name[2:]
    written.write(file_of(plugin), text[: key.start] + misspelt + text[key.start + len(name) :])

    refusal = written.refusal().splitlines()

    section = key.section.partition(" ")[0] if name == "name" else key.section
    hint = f'unknown key "{misspelt}" (did you mean "{name}"?)'
    assert f"{file_of(plugin)}:{key.line}: {section}: {hint}" in refusal
    # What else there is to say is only that the key is not there.
    missing = [line for line in refusal if line.endswith(f'the required key "{name}" is missing')]
    assert len(refusal) == 1 + len(missing)
