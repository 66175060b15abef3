"""Wrong model files: bodies, footprints, joints and plugins."""

from typing import Dict

from wrong_files.case import MODEL, PLUGINS, Case

# fmt: off
WRONG_MODELS: Dict[str, Case] = {
    # Bodies
    "no bodies": (MODEL, None, "plugins: []\n",
     'robot.model.yaml:1: the required key "bodies" is missing'),
    "an empty list of bodies": (MODEL, None, "bodies: []\n",
     "robot.model.yaml:1: bodies: expected at least one body, found none"),
    "no body that is enabled": (MODEL, None, "bodies:\n  - {name: base, enabled: false}\n",
     "robot.model.yaml:2: bodies: expected at least one body, found none"),
    "no name of a body": (MODEL, "- name: base\n    enabled", "- enabled",
     'robot.model.yaml:2: bodies[0]: the required key "name" is missing\n'
     'robot.model.yaml:29: joints[0].bodies[0].name: the model has no body "base"'),
    "two bodies of a name": (MODEL, "- name: wheel", "- name: base",
     'robot.model.yaml:19: bodies[1].name: the name "base" is given twice\n'
     'robot.model.yaml:31: joints[0].bodies[1].name: the model has no body "wheel"'),
    "maybe enabled": (MODEL, "enabled: true", "enabled: maybe",
     'robot.model.yaml:3: bodies[0].enabled: expected true or false, found "maybe"'),
    "an unknown type of body": (MODEL, "type: dynamic", "type: dynamik",
     "robot.model.yaml:5: bodies[0].type: expected static, kinematic or dynamic (did "
     'you mean "dynamic"?), found "dynamik"'),
    "a body's pose that is none": (MODEL, "pose: [0, 0, 0]", "pose: [0, 0, 0, 0]",
     "robot.model.yaml:4: bodies[0].pose: expected [x, y, yaw], found [0, 0, 0, 0]"),
    "a body's colour that is none": (MODEL, "color: [1, 1, 1, 0.5]", "color: [1, 1, 1, -0.5]",
     "robot.model.yaml:6: bodies[0].color: expected [r, g, b, alpha], each 0 to 1, found "
     "[1, 1, 1, -0.5]"),
    "negative damping": (MODEL, "linear_damping: 0", "linear_damping: -1",
     "robot.model.yaml:7: bodies[0].linear_damping: expected a number of 0 or more, " "found -1"),
    "infinite damping": (MODEL, "angular_damping: 0", "angular_damping: .inf",
     "robot.model.yaml:8: bodies[0].angular_damping: expected a finite number, found .inf"),
    "an unknown key of a body": (MODEL, "angular_damping: 0", "angular_dampening: 0",
     'robot.model.yaml:8: bodies[0] "base": unknown key "angular_dampening" (did you '
     'mean "angular_damping"?)'),
    "an unknown key of the model": (MODEL, "joints:", "joint:",
     'robot.model.yaml:24: unknown key "joint" (did you mean "joints"?)'),
    "no footprints": (MODEL, None, "bodies:\n  - name: base\n",
     'robot.model.yaml:2: bodies[0] "base": the required key "footprints" is missing'),
    "wrong in the only body": (MODEL, None, "bodies:\n" "  - name: base\n"
     "    footprints: [{type: circle, radius: 0, density: 1}]\n",
     "robot.model.yaml:3: bodies[0].footprints[0].radius: expected a number above 0, " "found 0"),
    # Footprints
    "no type of a footprint": (MODEL, "- type: circle\n        radius", "- radius",
     'robot.model.yaml:10: bodies[0].footprints[0]: the required key "type" is missing'),
    "an unknown type of a footprint": (MODEL, "type: circle", "type: box",
     "robot.model.yaml:10: bodies[0].footprints[0].type: expected circle or polygon, "
     'found "box"'),
    "no radius": (MODEL, "radius: 0.5\n        center", "center",
     'robot.model.yaml:10: bodies[0].footprints[0]: the required key "radius" is missing'),
    "a radius of zero": (MODEL, "radius: 0.5", "radius: 0",
     "robot.model.yaml:11: bodies[0].footprints[0].radius: expected a number above 0, "
     "found 0"),
    "an infinite radius": (MODEL, "radius: 0.5", "radius: .inf",
     "robot.model.yaml:11: bodies[0].footprints[0].radius: expected a finite number, "
     "found .inf"),
    "a center in 3D": (MODEL, "center: [0, 0]", "center: [0, 0, 0]",
     "robot.model.yaml:12: bodies[0].footprints[0].center: expected [x, y], found [0, " "0, 0]"),
    "no density": (MODEL, "density: 1\n        friction", "friction",
     'robot.model.yaml:10: bodies[0].footprints[0]: the required key "density" is missing'),
    "a negative density": (MODEL, "density: 1", "density: -1",
     "robot.model.yaml:13: bodies[0].footprints[0].density: expected a number of 0 or "
     "more, found -1"),
    "NaN for a density": (MODEL, "density: 1", "density: .nan",
     "robot.model.yaml:13: bodies[0].footprints[0].density: expected a number, found .nan"),
    "negative friction": (MODEL, "friction: 0.1", "friction: -0.1",
     "robot.model.yaml:14: bodies[0].footprints[0].friction: expected a number of 0 "
     "or more, found -0.1"),
    "negative restitution": (MODEL, "restitution: 0", "restitution: -1",
     "robot.model.yaml:15: bodies[0].footprints[0].restitution: expected a number of "
     "0 or more, found -1"),
    "an unknown layer": (MODEL, "[map, walls]", "[map, wals]",
     'robot.model.yaml:16: bodies[0].footprints[0].layers: no layer is named "wals" '
     '(did you mean "walls"?); there are: map, walls, lines, floor'),
    "a map for layers of a footprint": (MODEL, "[map, walls]", "{map: true}",
     "robot.model.yaml:16: bodies[0].footprints[0].layers: expected a string, found a map"),
    "a number for collision": (MODEL, "collision: true", "collision: 2",
     "robot.model.yaml:17: bodies[0].footprints[0].collision: expected true or false, "
     "found 2"),
    "an unknown key of a footprint": (MODEL, "sensor: false", "senser: false",
     'robot.model.yaml:18: bodies[0].footprints[0]: unknown key "senser" (did you '
     'mean "sensor"?)'),
    "a polygon's key at a circle": (MODEL, "radius: 0.5", "radius: 0.5\n        points: []",
     'robot.model.yaml:12: bodies[0].footprints[0]: unknown key "points"'),
    "no points": (MODEL, "points: [[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]\n        ", "",
     'robot.model.yaml:21: bodies[1].footprints[0]: the required key "points" is missing'),
    "two vertices": (MODEL, "[[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]", "[[0, 0], [1, 0]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a list of 3 to 8 "
     "points [x, y], found [[0, 0], [1, 0]]"),
    "nine vertices": (MODEL, "[[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]",
     "[[0, 0], [1, 0], [2, 1], [3, 3], [3, 4], [2, 5], [1, 5], [0, 4], [-1, 2]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a list of 3 to 8 "
     "points [x, y], found [[0, 0], [1, 0], [2, 1], [3, 3], [3, 4], [2, 5], [1, 5], ..."),
    "a vertex that is none": (MODEL, "[[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]",
     "[[0, 0], [1, 0], [1, a]]",
     'robot.model.yaml:22: bodies[1].footprints[0].points[2]: expected [x, y], found [1, "a"]'),
    "vertices without brackets": (MODEL, "[[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]",
     "[0.02, 0, 0.2, 0, 0.2, 0.1]",
     "robot.model.yaml:22: bodies[1].footprints[0].points[0]: expected [x, y], found 0.02"),
    "vertices in a line": (MODEL, "[[0.02, 0], [0.2, 0], [0.2, 0.1], [0.02, 0.1]]",
     "[[0, 0], [1, 1], [2, 2]]",
     "robot.model.yaml:21: bodies[1].footprints[0]: a polygon is too small or too "
     "thin: Box2D finds no area in it"),
    # Joints
    "no type of a joint": (MODEL, "- type: revolute\n    name", "- name",
     'robot.model.yaml:25: joints[0] "hinge": the required key "type" is missing'),
    "an unknown type of a joint": (MODEL, "type: revolute", "type: revolut",
     "robot.model.yaml:25: joints[0].type: expected revolute or weld (did you mean "
     '"revolute"?), found "revolut"'),
    "no name of a joint": (MODEL, "    name: hinge\n", "",
     'robot.model.yaml:25: joints[0]: the required key "name" is missing'),
    "two joints of a name": (MODEL, "name: hub\n    enabled: false", "name: hinge",
     'robot.model.yaml:33: joints[1].name: the name "hinge" is given twice'),
    "an unknown body": (MODEL, "{name: wheel, anchor: [0, 0]}", "{name: weel, anchor: [0, 0]}",
     'robot.model.yaml:31: joints[0].bodies[1].name: the model has no body "weel" '
     '(did you mean "wheel"?)'),
    "a body of no name": (MODEL, "{name: wheel, anchor: [0, 0]}", '{name: "", anchor: [0, 0]}',
     'robot.model.yaml:31: joints[0].bodies[1].name: expected a name of at most 255 characters, '
     'on one line, found ""'),
    "one body": (MODEL, "      - {name: wheel, anchor: [0, 0]}\n", "",
     "robot.model.yaml:30: joints[0].bodies: expected two bodies, found 1"),
    "a joint to a body that is not enabled": (MODEL, "- name: wheel",
     "- name: wheel\n    enabled: false",
     'robot.model.yaml:32: joints[0].bodies[1].name: the model has no body "wheel"'),
    "a body joined to itself": (MODEL, "{name: wheel, anchor: [0, 0]}",
     "{name: base, anchor: [0, 0]}",
     'robot.model.yaml:30: joints[0].bodies: expected two bodies, found "base" twice'),
    "no bodies of a joint": (MODEL, None, "bodies:\n" "  - {name: base, footprints: []}\n"
     "joints:\n" "  - {name: hinge, type: weld}\n",
     'robot.model.yaml:4: joints[0] "hinge": the required key "bodies" is missing'),
    "no anchor": (MODEL, "{name: wheel, anchor: [0, 0]}", "{name: wheel}",
     'robot.model.yaml:31: joints[0].bodies[1] "wheel": the required key "anchor" is ' "missing"),
    "an unknown key of an anchor": (MODEL, "{name: wheel, anchor: [0, 0]}",
     "{name: wheel, anchor: [0, 0], angle: 1}",
     'robot.model.yaml:31: joints[0].bodies[1] "wheel": unknown key "angle"'),
    "limits the wrong way round": (MODEL, "limits: [-1, 1]", "limits: [1, -1]",
     "robot.model.yaml:27: joints[0].limits: expected [lower, upper], found 1 above -1"),
    "one limit": (MODEL, "limits: [-1, 1]", "limits: [1]",
     "robot.model.yaml:27: joints[0].limits: expected a list of 2 numbers, found [1]"),
    "a hinge with an angle": (MODEL, "limits: [-1, 1]", "angle: 1",
     'robot.model.yaml:27: joints[0] "hinge": unknown key "angle"'),
    "a weld with limits": (MODEL, "enabled: false\n    angle: 0", "limits: [0, 0]",
     'robot.model.yaml:34: joints[1] "hub": unknown key "limits"'),
    "a negative frequency": (MODEL, "enabled: false\n    angle: 0\n    frequency: 0",
     "frequency: -1",
     "robot.model.yaml:34: joints[1].frequency: expected a number of 0 or more, found -1"),
    "a negative damping ratio": (MODEL,
     "enabled: false\n    angle: 0\n    frequency: 0\n    damping: 0", "damping: -1",
     "robot.model.yaml:34: joints[1].damping: expected a number of 0 or more, found -1"),
    # Plugins of a model
    "no type of a plugin": (MODEL, "- type: DiffDrive\n    name", "- name",
     'robot.model.yaml:42: plugins[0] "drive": the required key "type" is missing'),
    "no name of a plugin": (MODEL, "    name: drive\n", "",
     'robot.model.yaml:42: plugins[0]: the required key "name" is missing'),
    "two plugins of a name": (MODEL, "name: laser", "name: drive",
     'robot.model.yaml:47: plugins[1].name: the name "drive" is given twice'),
    "a covariance without commas at its lines' ends": (MODEL, "linear_dynamics:",
     "odom_pose_covariance: [0, 0\n      0, 0]\n    odom_twist_covariance: ["
     + "\n      ".join(["0, 0, 0, 0, 0, 0"] * 6) + "]\n    linear_dynamics:",
     "robot.model.yaml:45: plugins[0].odom_pose_covariance: expected a list of 36 numbers, found "
     '[0, "0 0", 0]\n'
     "robot.model.yaml:47: plugins[0].odom_twist_covariance: expected a list of 36 numbers, found "
     '31 entries: [0, 0, 0, 0, 0, "0 0", 0, 0, 0, 0, "0 0", 0, ...'),
    "an unknown plugin nearly known": (MODEL, "type: DiffDrive", "type: DifDrive",
     'robot.model.yaml:42: plugins[0].type: unknown plugin type "DifDrive" (did you '
     f'mean "DiffDrive"?); there are: {PLUGINS}'),
    "a plugin in capitals": (MODEL, "type: Laser", "type: LASER",
     'robot.model.yaml:46: plugins[1].type: unknown plugin type "LASER" (did you '
     f'mean "Laser"?); there are: {PLUGINS}'),
    "a plugin of another package": (MODEL, "type: DiffDrive", "type: my_plugins::Diff",
     'robot.model.yaml:42: plugins[0].type: unknown plugin type "my_plugins::Diff" '
     f'(did you mean "DiffDrive"?); there are: {PLUGINS}'),
    "a plugin of the world in a model": (MODEL, "type: DiffDrive", "type: RandomWall",
     'robot.model.yaml:42: plugins[0].type: "RandomWall" is not a ModelPlugin: '
     "flatland_plugins.random_wall.RandomWall"),
}
# fmt: on
