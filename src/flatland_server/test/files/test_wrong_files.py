"""Wrong files: each is answered by exactly what is wrong and where, and never by a traceback."""

import time
from typing import Dict, Optional, Tuple, Union

import pytest

from flatland_server.exceptions import FlatlandError, YamlError

WORLD, MAP, LINES, DATA = "world.yaml", "map.yaml", "lines.yaml", "lines.dat"
MODEL = "robot.model.yaml"

PLUGINS = (
    "BoolSensor, Bumper, Crowd, DiffDrive, Gps, Imu, Laser, ModelTfPublisher, OmniDrive, "
    "RandomWall, TricycleDrive, Tween"
)

# fmt: off
# What is wrong: the file, the text in it that is replaced (None is all of it) by another one, and
# the whole message.
Case = Tuple[str, Optional[str], Union[str, bytes], str]
WRONG: Dict[str, Case] = {
    # The world
    "no properties": (WORLD, "properties: {velocity_iterations: 10, position_iterations: 10}\n",
     "", 'world.yaml:1: the required key "properties" is missing'),
    "a text for properties": (WORLD, "{velocity_iterations: 10, position_iterations: 10}", "fast",
     'world.yaml:1: properties: expected a map, found "fast"'),
    "no iterations": (WORLD, "velocity_iterations: 10", "velocity_iterations: 0",
     "world.yaml:1: properties.velocity_iterations: expected a whole number of 1 or "
     "more, found 0"),
    "half an iteration": (WORLD, "velocity_iterations: 10", "velocity_iterations: 2.5",
     "world.yaml:1: properties.velocity_iterations: expected a whole number, found 2.5"),
    "an unknown property": (WORLD, "velocity_iterations: 10", "velocity_iteration: 10",
     'world.yaml:1: properties: unknown key "velocity_iteration" (did you mean '
     '"velocity_iterations"?)'),
    "no layers": (WORLD, None, "properties: {}\n",
     'world.yaml:1: the required key "layers" is missing'),
    "a map for layers": (WORLD, None, "properties: {}\nlayers: {name: map}\n",
     "world.yaml:2: layers: expected a list, found a map"),
    "a text for a layer": (WORLD, "{name: lines, map: lines.yaml}", "lines.yaml",
     'world.yaml:7: layers[1]: expected a map, found "lines.yaml"'),
    "an unknown key of the world": (WORLD, "models:", "model:",
     'world.yaml:9: unknown key "model" (did you mean "models"?)'),
    "a key without a likeness": (WORLD, "models:", "robots:",
     'world.yaml:9: unknown key "robots"'),
    "a key given twice": (WORLD, "models:", "properties: {}\nmodels:",
     'world.yaml:9: the key "properties" is given twice'),
    "a key given twice in an entry": (WORLD, "    namespace: r1", "    name: robot2",
     'world.yaml:11: models[0]: the key "name" is given twice'),
    "a list as a key": (WORLD, "models:", "[a, b]: 1\nmodels:",
     'world.yaml:9: expected a key, found ["a", "b"]'),
    # Layers
    "no name of a layer": (WORLD, "- name: floor", "- {}",
     'world.yaml:8: layers[2]: the required key "name" is missing'),
    "an empty name of a layer": (WORLD, "- name: floor", "- name: ''",
     "world.yaml:8: layers[2].name: expected a name, found an empty one"),
    "an empty list of names": (WORLD, "- name: floor", "- name: []",
     "world.yaml:8: layers[2].name: expected a name or a list of names, found an " "empty list"),
    "a map for a layer's name": (WORLD, "- name: floor", "- name: {first: floor}",
     "world.yaml:8: layers[2].name: expected a text, found a map"),
    "a layer's name that is no topic": (WORLD, "- name: floor", "- name: ground floor",
     'world.yaml:8: layers[2].name: expected a name of letters, digits and "_" (it '
     'names a ROS topic), found "ground floor"'),
    "two layers of a name": (WORLD, "- name: floor", "- name: lines",
     'world.yaml:8: layers[2].name: the layer name "lines" is given twice'),
    "a name twice in one layer": (WORLD, "[map, walls]", "[map, walls, map]",
     'world.yaml:3: layers[0].name: the layer name "map" is given twice'),
    "a layer called all": (WORLD, "- name: floor", "- name: all",
     'world.yaml:8: layers[2].name: the name "all" stands for all layers'),
    "17 layers": (WORLD, "- name: floor",
     "- name: floor" + "".join(f"\n  - name: extra{i}" for i in range(13)),
     "world.yaml:21: layers[15].name: expected at most 16 layer names in all, found more"),
    "17 names in a layer": (WORLD, "- name: floor",
     "- name: " + str([f"extra{i}" for i in range(14)]),
     "world.yaml:8: layers[2].name: expected at most 16 layer names in all, found more"),
    "three parts of a colour": (WORLD, "color: [0.4, 0.4, 0.4, 1]", "color: [0.4, 0.4, 0.4]",
     "world.yaml:5: layers[0].color: expected [r, g, b, alpha], found [0.4, 0.4, 0.4]"),
    "too bright a colour": (WORLD, "color: [0.4, 0.4, 0.4, 1]", "color: [255, 255, 255, 1]",
     "world.yaml:5: layers[0].color: expected [r, g, b, alpha], found [255, 255, 255, 1]"),
    "a colour's name": (WORLD, "color: [0.4, 0.4, 0.4, 1]", "color: grey",
     'world.yaml:5: layers[0].color: expected [r, g, b, alpha], found "grey"'),
    "an unknown key of a layer": (WORLD, "color: [0.4", "colour: [0.4",
     'world.yaml:5: layers[0]: unknown key "colour" (did you mean "color"?)'),
    "an unknown key of a layer's properties": (WORLD, "{min_z: 0, max_z: 1}", "{minz: 0}",
     'world.yaml:6: layers[0].properties.debug: unknown key "minz" (did you mean "min_z"?)'),
    "a layer's height that is no number": (WORLD, "{min_z: 0, max_z: 1}", "{min_z: low}",
     'world.yaml:6: layers[0].properties.debug.min_z: expected a number, found "low"'),
    "a map that is not there": (WORLD, "map: map.yaml", "map: office.yaml",
     "world.yaml:4: layers[0].map: expected a file, but office.yaml is not there"),
    "a map that is a folder": (WORLD, "map: map.yaml", "map: folder",
     "world.yaml:4: layers[0].map: expected a file, but folder is a folder"),
    "a number for a map": (WORLD, "map: map.yaml", "map: 5",
     "world.yaml:4: layers[0].map: expected a file, but 5 is not there"),
    "a list for a map": (WORLD, "map: map.yaml", "map: [map.yaml]",
     'world.yaml:4: layers[0].map: expected a text, found ["map.yaml"]'),
    # Maps of images
    "no image": (MAP, "image: map.png\n", "", 'map.yaml:1: the required key "image" is missing'),
    "an image that is not there": (MAP, "map.png", "office.png",
     "map.yaml:1: image: expected a file, but office.png is not there"),
    "an image that is a folder": (MAP, "map.png", "folder",
     "map.yaml:1: image: expected a file, but folder is a folder"),
    "an empty name of an image": (MAP, "map.png", "''",
     "map.yaml:1: image: expected a file, found an empty text"),
    "an image that is no image": (MAP, "map.png", "lines.dat",
     "lines.dat: is not an image of a known format"),
    "an empty image file": (MAP, "map.png", "empty.png",
     "empty.png: is not an image of a known format"),
    "a truncated image": (MAP, "map.png", "cut.png",
     "cut.png: cannot be read as an image: image file is truncated"),
    "a corrupt image": (MAP, "map.png", "corrupt.png",
     "corrupt.png: cannot be read as an image: broken data stream when reading image file"),
    "no resolution": (MAP, "resolution: 0.05\n", "",
     'map.yaml:1: the required key "resolution" is missing'),
    "a resolution of zero": (MAP, "resolution: 0.05", "resolution: 0",
     "map.yaml:2: resolution: expected a number above 0, found 0"),
    "a negative resolution": (MAP, "resolution: 0.05", "resolution: -0.05",
     "map.yaml:2: resolution: expected a number above 0, found -0.05"),
    "an infinite resolution": (MAP, "resolution: 0.05", "resolution: .inf",
     "map.yaml:2: resolution: expected a finite number, found .inf"),
    "NaN for a resolution": (MAP, "resolution: 0.05", "resolution: .nan",
     "map.yaml:2: resolution: expected a number, found .nan"),
    "a unit in the resolution": (MAP, "resolution: 0.05", "resolution: 0.05 m",
     'map.yaml:2: resolution: expected a number, found "0.05 m"'),
    "no origin": (MAP, "origin: [-1, -2, 0.5]\n", "",
     'map.yaml:1: the required key "origin" is missing'),
    "an origin without yaw": (MAP, "origin: [-1, -2, 0.5]", "origin: [-1, -2]",
     "map.yaml:3: origin: expected [x, y, yaw], found [-1, -2]"),
    "an infinite origin": (MAP, "origin: [-1, -2, 0.5]", "origin: [.inf, -2, 0.5]",
     "map.yaml:3: origin: expected [x, y, yaw], found [.inf, -2, 0.5]"),
    "no threshold": (MAP, "occupied_thresh: 0.65\n", "",
     'map.yaml:1: the required key "occupied_thresh" is missing'),
    "a threshold that is no number": (MAP, "occupied_thresh: 0.65", "occupied_thresh: dark",
     'map.yaml:5: occupied_thresh: expected a number, found "dark"'),
    "an unknown type of map": (MAP, "negate: 0", "type: lines",
     'map.yaml:4: type: expected image or line_segments, found "lines"'),
    "an unknown key of a map": (MAP, "resolution: 0.05", "resolution: 0.05\nresolutoin: 0.05",
     'map.yaml:3: unknown key "resolutoin"'),
    "a map that is a list": (MAP, None, "- image: map.png\n",
     "map.yaml:1: expected a map, found [a map]"),
    "an empty map": (MAP, None, "", "map.yaml: expected a map, found an empty file"),
    # Maps of line segments
    "no data": (LINES, "data: lines.dat\n", "",
     'lines.yaml:1: the required key "data" is missing'),
    "data that is not there": (LINES, "lines.dat", "walls.dat",
     "lines.yaml:2: data: expected a file, but walls.dat is not there"),
    "no scale": (LINES, "scale: 0.1\n", "", 'lines.yaml:1: the required key "scale" is missing'),
    "a scale of zero": (LINES, "scale: 0.1", "scale: 0",
     "lines.yaml:3: scale: expected a number above 0, found 0"),
    "an image's key": (LINES, "scale: 0.1", "scale: 0.1\nresolution: 0.1",
     'lines.yaml:4: unknown key "resolution"'),
    "three numbers in a line": (DATA, "2 3 -1 2", "2 3 -1",
     'lines.dat:2: expected "x1 y1 x2 y2", found "2 3 -1"'),
    "five numbers in a line": (DATA, "2 3 -1 2", "2 3 -1 2 5",
     'lines.dat:2: expected "x1 y1 x2 y2", found "2 3 -1 2 5"'),
    "a word in a line": (DATA, "2 3 -1 2", "2 3 x 2",
     'lines.dat:2: expected "x1 y1 x2 y2", found "2 3 x 2"'),
    "commas in a line": (DATA, "2 3 -1 2", "2, 3, -1, 2",
     'lines.dat:2: expected "x1 y1 x2 y2", found "2, 3, -1, 2"'),
    "NaN in a line": (DATA, "2 3 -1 2", "2 3 nan 2",
     'lines.dat:2: expected "x1 y1 x2 y2", found "2 3 nan 2"'),
    "infinity in a line": (DATA, "2 3 -1 2", "2 3 inf 2",
     'lines.dat:2: expected "x1 y1 x2 y2", found "2 3 inf 2"'),
    "a line without length": (DATA, "2 3 -1 2", "2 3 2 3",
     "lines.dat:2: expected two different ends, found one point twice"),
    "data that is not text": (DATA, None, b"0 0 1 1\n\xff\xfe",
     "lines.dat: cannot be read: it is not UTF-8 text"),
    # Entries of models
    "no name of a model": (WORLD, "- name: robot\n    namespace", "- namespace",
     'world.yaml:10: models[0]: the required key "name" is missing'),
    "a model's name with a space": (WORLD, "- name: robot", "- name: my robot",
     'world.yaml:10: models[0].name: expected a name of letters, digits and "_" (it '
     'names a ROS topic), found "my robot"'),
    "two models of a name": (WORLD, "models:",
     "models:\n  - {name: robot, model: robot.model.yaml}",
     'world.yaml:11: models[1].name: the name "robot" is given twice'),
    "a namespace that is none": (WORLD, "namespace: r1", "namespace: 1 r",
     "world.yaml:11: models[0].namespace: expected a namespace of letters, digits and "
     '"_", beginning with a letter, found "1 r"'),
    "a pose without yaw": (WORLD, "pose: [1, 2, 0.5]", "pose: [1, 2]",
     "world.yaml:12: models[0].pose: expected [x, y, yaw], found [1, 2]"),
    "a word for a pose": (WORLD, "pose: [1, 2, 0.5]", "pose: here",
     'world.yaml:12: models[0].pose: expected [x, y, yaw], found "here"'),
    "NaN in a pose": (WORLD, "pose: [1, 2, 0.5]", "pose: [1, 2, .nan]",
     "world.yaml:12: models[0].pose: expected [x, y, yaw], found [1, 2, .nan]"),
    "no file of a model": (WORLD, "    model: robot.model.yaml\n", "",
     'world.yaml:10: models[0] "robot": the required key "model" is missing'),
    "a model that is not there": (WORLD, "robot.model.yaml", "robto.model.yaml",
     "world.yaml:13: models[0].model: expected a file, but robto.model.yaml is not there"),
    "a model that is a folder": (WORLD, "robot.model.yaml", "folder",
     "world.yaml:13: models[0].model: expected a file, but folder is a folder"),
    "an unknown key of an entry": (WORLD, "pose:", "position:",
     'world.yaml:12: models[0] "robot": unknown key "position"'),
    "a number for models": (WORLD, None, "properties: {}\nlayers: []\nmodels: 3\n",
     "world.yaml:3: models: expected a list, found 3"),
    "a plugin of the world that is unknown": (WORLD, "models:",
     "plugins: [{type: Weather, name: rain}]\nmodels:",
     'world.yaml:9: plugins[0].type: unknown plugin type "Weather"; there are: '
     + PLUGINS),
    "a model's plugin in the world": (WORLD, "models:",
     "plugins: [{type: Laser, name: eye}]\nmodels:",
     'world.yaml:9: plugins[0].type: "Laser" is not a WorldPlugin: '
     "flatland_plugins.laser.Laser"),
    # Bodies
    "no bodies": (MODEL, None, "plugins: []\n",
     'robot.model.yaml:1: the required key "bodies" is missing'),
    "an empty list of bodies": (MODEL, None, "bodies: []\n",
     "robot.model.yaml:1: bodies: expected at least one body, found none"),
    "a map for bodies": (MODEL, None, "bodies: {name: base}\n",
     "robot.model.yaml:1: bodies: expected a list, found a map"),
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
     "robot.model.yaml:6: bodies[0].color: expected [r, g, b, alpha], found [1, 1, 1, " "-0.5]"),
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
    "a negative radius": (MODEL, "radius: 0.5", "radius: -0.5",
     "robot.model.yaml:11: bodies[0].footprints[0].radius: expected a number above 0, "
     "found -0.5"),
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
     "robot.model.yaml:16: bodies[0].footprints[0].layers: expected a text, found a map"),
    "a number for collision": (MODEL, "collision: true", "collision: 2",
     "robot.model.yaml:17: bodies[0].footprints[0].collision: expected true or false, "
     "found 2"),
    "a word for sensor": (MODEL, "sensor: false", "sensor: maybe",
     "robot.model.yaml:18: bodies[0].footprints[0].sensor: expected true or false, "
     'found "maybe"'),
    "an unknown key of a footprint": (MODEL, "sensor: false", "senser: false",
     'robot.model.yaml:18: bodies[0].footprints[0]: unknown key "senser" (did you '
     'mean "sensor"?)'),
    "a polygon's key at a circle": (MODEL, "radius: 0.5", "radius: 0.5\n        points: []",
     'robot.model.yaml:12: bodies[0].footprints[0]: unknown key "points"'),
    "no points": (MODEL, "points: [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]\n        ", "",
     'robot.model.yaml:21: bodies[1].footprints[0]: the required key "points" is missing'),
    "two vertices": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]", "[[0, 0], [1, 0]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a list of 3 to 8 "
     "points [x, y], found [[0, 0], [1, 0]]"),
    "nine vertices": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 0], [1, 0], [2, 1], [3, 3], [3, 4], [2, 5], [1, 5], [0, 4], [-1, 2]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a list of 3 to 8 "
     "points [x, y], found [[0, 0], [1, 0], [2, 1], [3, 3], [3, 4], [2, 5], [1, 5], ..."),
    "a vertex that is none": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 0], [1, 0], [1, a]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected [x, y], found "
     '[[0, 0], [1, 0], [1, "a"]]'),
    "a dent": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 0], [4, 0], [2, 1], [4, 4]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a convex polygon, "
     "found one with a dent"),
    "a pentagram": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 3], [2, -3], [-3, 1], [3, 1], [-2, -3]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a convex polygon, "
     "found one with a dent"),
    "an hourglass": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 0], [1, 1], [1, 0], [0, 1]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a convex polygon, "
     "found one with a dent"),
    "a corner behind the others": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 0], [2, 0], [2, 1], [1, 2], [2, 3], [0, 3]]",
     "robot.model.yaml:22: bodies[1].footprints[0].points: expected a convex polygon, "
     "found one with a dent"),
    "vertices in a line": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[0, 0], [1, 1], [2, 2]]",
     "robot.model.yaml:21: bodies[1].footprints[0]: a polygon is too small or too "
     "thin: its corners fall together"),
    "three equal vertices": (MODEL, "[[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]]",
     "[[1, 1], [1, 1], [1, 1]]",
     "robot.model.yaml:21: bodies[1].footprints[0]: a polygon is too small or too "
     "thin: its corners fall together"),
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
    "one body": (MODEL, "      - {name: wheel, anchor: [0, 0]}\n", "",
     "robot.model.yaml:30: joints[0].bodies: expected two bodies, found 1"),
    "a joint to a body that is not enabled": (MODEL, "- name: wheel",
     "- name: wheel\n    enabled: false",
     'robot.model.yaml:32: joints[0].bodies[1].name: the model has no body "wheel"'),
    "three bodies": (MODEL, "{name: wheel, anchor: [0, 0]}",
     "{name: wheel, anchor: [0, 0]}\n      - {name: base, anchor: [1, 0]}",
     "robot.model.yaml:30: joints[0].bodies: expected two bodies, found 3"),
    "a body joined to itself": (MODEL, "{name: wheel, anchor: [0, 0]}",
     "{name: base, anchor: [0, 0]}",
     'robot.model.yaml:30: joints[0].bodies: expected two bodies, found "base" twice'),
    "no bodies of a joint": (MODEL, None, "bodies:\n" "  - {name: base, footprints: []}\n"
     "joints:\n" "  - {name: hinge, type: weld}\n",
     'robot.model.yaml:4: joints[0] "hinge": the required key "bodies" is missing'),
    "no anchor": (MODEL, "{name: wheel, anchor: [0, 0]}", "{name: wheel}",
     'robot.model.yaml:31: joints[0].bodies[1] "wheel": the required key "anchor" is ' "missing"),
    "one number for an anchor": (MODEL, "{name: wheel, anchor: [0, 0]}",
     "{name: wheel, anchor: 0}",
     "robot.model.yaml:31: joints[0].bodies[1].anchor: expected [x, y], found 0"),
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
    "a word for collide_connected": (MODEL, "collide_connected: false",
     "collide_connected: never",
     "robot.model.yaml:28: joints[0].collide_connected: expected true or false, found "
     '"never"'),
    # Plugins of a model
    "no type of a plugin": (MODEL, "- type: DiffDrive\n    name", "- name",
     'robot.model.yaml:42: plugins[0] "drive": the required key "type" is missing'),
    "no name of a plugin": (MODEL, "    name: drive\n", "",
     'robot.model.yaml:42: plugins[0]: the required key "name" is missing'),
    "two plugins of a name": (MODEL, "name: laser", "name: drive",
     'robot.model.yaml:47: plugins[1].name: the name "drive" is given twice'),
    "an unknown plugin nearly known": (MODEL, "type: DiffDrive", "type: DifDrive",
     'robot.model.yaml:42: plugins[0].type: unknown plugin type "DifDrive" (did you '
     f'mean "DiffDrive"?); there are: {PLUGINS}'),
    "a plugin of another package": (MODEL, "type: DiffDrive", "type: my_plugins::Diff",
     'robot.model.yaml:42: plugins[0].type: unknown plugin type "my_plugins::Diff" '
     f'(did you mean "DiffDrive"?); there are: {PLUGINS}'),
    "a plugin of the world in a model": (MODEL, "type: DiffDrive", "type: RandomWall",
     'robot.model.yaml:42: plugins[0].type: "RandomWall" is not a ModelPlugin: '
     "flatland_plugins.random_wall.RandomWall"),
    "an unknown body of a plugin": (MODEL, "name: drive\n    body: base",
     "name: drive\n    body: bsae",
     'robot.model.yaml:44: plugins[0].body: the model has no body "bsae" (did you '
     'mean "base"?); it has: base, wheel'),
    "no body of a plugin": (MODEL, "name: drive\n    body: base", "name: drive",
     'robot.model.yaml:42: plugins[0] "drive": the required key "body" is missing'),
    "an unknown key of DiffDrive": (MODEL, "linear_dynamics:", "linear_dynamic:",
     'robot.model.yaml:45: plugins[0] "drive": unknown key "linear_dynamic" (did you '
     'mean "linear_dynamics"?)'),
    "an unknown key of linear_dynamics": (MODEL, "{velocity_limit: 1}", "{velocty_limit: 1}",
     'robot.model.yaml:45: plugins[0].linear_dynamics: unknown key "velocty_limit" '
     '(did you mean "velocity_limit"?)'),
    "a negative limit": (MODEL, "{velocity_limit: 1}", "{velocity_limit: -1}",
     "robot.model.yaml:45: plugins[0].linear_dynamics.velocity_limit: expected a "
     "number of 0 or more, found -1"),
    "an unknown key of Laser": (MODEL, "range: 10", "raneg: 10",
     'robot.model.yaml:46: plugins[1] "laser": the required key "range" is missing\n'
     'robot.model.yaml:49: plugins[1] "laser": unknown key "raneg" (did you mean "range"?)'),
    "no range": (MODEL, "    range: 10\n", "",
     'robot.model.yaml:46: plugins[1] "laser": the required key "range" is missing'),
    "a range of zero": (MODEL, "range: 10", "range: 0",
     "robot.model.yaml:49: plugins[1].range: expected a number above 0, found 0"),
    "no angle": (MODEL, "    angle: {min: -1, max: 1, increment: 0.1}\n", "",
     'robot.model.yaml:46: plugins[1] "laser": the required key "angle" is missing'),
    "an angle without an increment": (MODEL, ", increment: 0.1", "",
     'robot.model.yaml:50: plugins[1].angle: the required key "increment" is missing'),
    "an increment that never arrives": (MODEL, "increment: 0.1", "increment: -0.1",
     "robot.model.yaml:50: plugins[1].angle: expected an increment that leads from "
     "min to max in 1 to 1000000 beams, found -0.1 from -1 to 1"),
    "a scan's rate of zero": (MODEL, "range: 10", "range: 10\n    update_rate: 0",
     "robot.model.yaml:50: plugins[1].update_rate: expected a number above 0, found 0"),
    "a laser on an unknown layer": (MODEL, "range: 10", "range: 10\n    layers: [floors]",
     'robot.model.yaml:50: plugins[1].layers: no layer is named "floors" (did you '
     'mean "floor"?); there are: map, walls, lines, floor'),
    "an endless scan": (MODEL, "increment: 0.1", "increment: 0.0000001",
     "robot.model.yaml:50: plugins[1].angle: expected an increment that leads from "
     "min to max in 1 to 1000000 beams, found 1e-07 from -1 to 1"),
    # YAML
    "an empty file": (WORLD, None, "", "world.yaml: expected a map, found an empty file"),
    "only comments": (WORLD, None, "# nothing\n# at all\n",
     "world.yaml: expected a map, found an empty file"),
    "null": (WORLD, None, "null\n", "world.yaml:1: expected a map, found nothing"),
    "only the beginning of a document": (WORLD, None, "---\n",
     "world.yaml:2: expected a map, found nothing"),
    "a list for a world": (WORLD, None, "- properties: {}\n",
     "world.yaml:1: expected a map, found [a map]"),
    "a text for a world": (WORLD, None, "world\n", 'world.yaml:1: expected a map, found "world"'),
    "two documents": (WORLD, None, "properties: {}\n---\nlayers: []\n",
     "world.yaml:3: expected one document, found another one"),
    "a tab for indentation": (WORLD, None, "properties: {}\nlayers:\n\t- name: map\n",
     "world.yaml:3: is not valid YAML: while scanning for the next token found "
     "character that cannot start any token"),
    "a bracket that is not closed": (WORLD, "[1, 2, 0.5]", "[1, 2, 0.5",
     "world.yaml:13: is not valid YAML: while parsing a flow sequence did not find "
     "expected ',' or ']'"),
    "a quote that is not closed": (WORLD, "namespace: r1", "namespace: 'r1",
     "world.yaml:14: is not valid YAML: while scanning a quoted scalar found "
     "unexpected end of stream"),
    "wrong indentation": (WORLD, "    pose:", "   pose:",
     "world.yaml:12: is not valid YAML: while parsing a block collection did not find "
     "expected '-' indicator"),
    "an unknown alias": (WORLD, "[1, 2, 0.5]", "*here",
     "world.yaml:12: is not valid YAML: found undefined alias"),
    "a control character": (WORLD, None, b"properties: {}\x07\n",
     "world.yaml: is not valid YAML: unacceptable character #x0007: control "
     "characters are not allowed"),
    "a zero byte": (WORLD, None, b"properties: {}\x00\n",
     "world.yaml: is not valid YAML: unacceptable character #x0000: control "
     "characters are not allowed"),
    "not UTF-8": (WORLD, None, b"properties: {}\nlayers: [{name: caf\xe9}]\n",
     "world.yaml: is not UTF-8 text: byte 34 is wrong"),
    "UTF-16": (WORLD, None,
     b"\xff\xfep\x00r\x00o\x00p\x00e\x00r\x00t\x00i\x00e\x00s\x00:\x00 \x00{\x00}\x00\n\x00",
     "world.yaml: is not UTF-8 text: byte 0 is wrong"),
    "ten thousand brackets": (WORLD, None, "properties: " + "[" * 10_000 + "]" * 10_000,
     "world.yaml:1: expected at most 100 levels, found more"),
    "ten thousand open brackets": (WORLD, None, "[" * 10_000,
     "world.yaml:1: expected at most 100 levels, found more"),
    "an anchor that contains itself": (WORLD, None, "properties: {}\nlayers: &all\n  - *all\n",
     "world.yaml:2: contains itself"),
    "a map that contains itself": (WORLD, None, "&world\nproperties: *world\nlayers: []\n",
     "world.yaml:1: contains itself"),
    "a map merged with itself": (WORLD, None, "&world\nproperties: {}\n<<: *world\n",
     "world.yaml:1: contains itself"),
    "a merged text": (WORLD, None, "properties: {}\n<<: layers\n",
     "world.yaml:2: expected a map or a list of maps after <<"),
    "a model that is not YAML": (MODEL, None, "bodies: [\n",
     "robot.model.yaml:2: is not valid YAML: while parsing a flow node did not find "
     "expected node content"),
    "a map that is not UTF-8": (MAP, None, b"image: \xff\n",
     "map.yaml: is not UTF-8 text: byte 7 is wrong"),
    # Includes and expressions
    "an include that is not there": (WORLD, "[1, 2, 0.5]", "$include pose.yaml",
     "world.yaml:12: there is no file pose.yaml"),
    "an include of a folder": (WORLD, "[1, 2, 0.5]", "$include folder",
     "world.yaml:12: there is no file folder"),
    "a file that includes itself": (WORLD, "[1, 2, 0.5]", "$include world.yaml",
     "world.yaml:12: world.yaml includes itself"),
    "two files that include each other": (WORLD, "[1, 2, 0.5]", "$include ping.yaml",
     "pong.yaml:1: ping.yaml includes itself"),
    "an include of two documents": (WORLD, "[1, 2, 0.5]", "$include two.yaml",
     "world.yaml:12: expected one document in two.yaml, found 2; $[include] takes several"),
    "an include of nothing": (WORLD, "[1, 2, 0.5]", "$include empty.yaml",
     "empty.yaml: expected a map, found an empty file"),
    "a wrong value in an include": (WORLD, "[1, 2, 0.5]", "$include short_pose.yaml",
     "short_pose.yaml:2: models[0].pose: expected [x, y, yaw], found [1, 2]"),
    "a wrong entry in a list that is included": (WORLD, "- name: floor", "- $[include] two.yaml",
     'two.yaml:3: layers[3]: the required key "name" is missing\n'
     'two.yaml:3: layers[3]: unknown key "naem" (did you mean "name"?)'),
    "$[include] where there is no list": (WORLD, "[1, 2, 0.5]", "$[include] two.yaml",
     'world.yaml:12: models[0].pose: expected [x, y, yaw], found "$[include] two.yaml"'),
    "an include without a file": (WORLD, "[1, 2, 0.5]", "$include",
     'world.yaml:12: models[0].pose: expected [x, y, yaw], found "$include"'),
    "bad Lua": (WORLD, "[1, 2, 0.5]", "$eval 1 +",
     "world.yaml:12: $eval: unexpected symbol near '1', in: 1 +"),
    "unfinished Lua": (WORLD, "[1, 2, 0.5]", '"$eval if true then"',
     "world.yaml:12: $eval: 'end' expected near '<eof>', in: if true then"),
    "Lua that fails": (WORLD, "[1, 2, 0.5]", "\"$eval error('not today')\"",
     "world.yaml:12: $eval: not today, in: error('not today')"),
    "arithmetic on nothing": (WORLD, "[1, 2, 0.5]", "$eval 1 + nil",
     "world.yaml:12: $eval: attempt to perform arithmetic on a nil value, in: 1 + nil"),
    "endless Lua": (WORLD, "[1, 2, 0.5]", "$eval while true do end",
     "world.yaml:12: $eval: does not end within 1 s, in: while true do end"),
    "Lua that eats memory": (WORLD, "[1, 2, 0.5]", '$eval ("x"):rep(2^31 - 1)',
     'world.yaml:12: $eval: not enough memory, in: ("x"):rep(2^31 - 1)'),
    "a function from Lua": (WORLD, "[1, 2, 0.5]", "$eval print",
     'world.yaml:12: $eval: "print" is not available in $eval, in: print'),
    "Lua's files": (WORLD, "[1, 2, 0.5]", "$eval io.open('/etc/passwd')",
     "world.yaml:12: $eval: \"io\" is not available in $eval, in: io.open('/etc/passwd')"),
    "a result of the wrong type": (WORLD, "[1, 2, 0.5]", "$eval 1 + 1",
     "world.yaml:12: models[0].pose: expected [x, y, yaw], found 2"),
    "a table with gaps": (WORLD, "[1, 2, 0.5]", '"$eval {1, 2, nil, 4}"',
     "world.yaml:12: $eval: expected a table with keys 1, 2, 3 ..., found gaps, in: "
     "{1, 2, nil, 4}"),
    "a parameter that is not set": (WORLD, "[1, 2, 0.5]", "$eval param('/pose')",
     'world.yaml:12: models[0].pose: expected [x, y, yaw], found ""'),
}
# fmt: on

# Numbers that are numbers, and too much for physics: file, replaced, by, the file that is at fault.
# How it is said is physics' own affair.
TOO_MUCH = {
    "iterations": (WORLD, "velocity_iterations: 10", "velocity_iterations: 99999999999", WORLD),
    "a model's position": (WORLD, "[1, 2, 0.5]", "[1e39, 2, 0.5]", ""),
    "an image's resolution": (MAP, "resolution: 0.05", "resolution: 1e300", MAP),
    "an image's tiny resolution": (MAP, "resolution: 0.05", "resolution: 1e-300", MAP),
    "an image's origin": (MAP, "[-1, -2, 0.5]", "[1e300, 0, 0]", MAP),
    "a scale": (LINES, "scale: 0.1", "scale: 1e300", LINES),
    "a tiny scale": (LINES, "scale: 0.1", "scale: 1e-300", LINES),
    "a line segment": (DATA, "2 3 -1 2", "1e300 1e300 0 0", "lines."),
    "a radius": (MODEL, "radius: 0.5", "radius: 1e300", MODEL),
    "a tiny radius": (MODEL, "radius: 0.5", "radius: 1e-300", MODEL),
    "a center": (MODEL, "center: [0, 0]", "center: [1e300, 0]", MODEL),
    "a point": (MODEL, "[0.2, 0.1]", "[1e300, 0.1]", MODEL),
    "a density": (MODEL, "density: 1", "density: 1e300", MODEL),
    "friction": (MODEL, "friction: 0.1", "friction: 1e300", MODEL),
    "restitution": (MODEL, "restitution: 0", "restitution: 1e300", MODEL),
    "a body's pose": (MODEL, "pose: [0, 0, 0]", "pose: [1e300, 0, 0]", ""),
    "damping": (MODEL, "linear_damping: 0", "linear_damping: 1e300", ""),
    "an anchor": (MODEL, "anchor: [0.5, 0]", "anchor: [1e300, 0]", ""),
    "limits of a hinge": (MODEL, "limits: [-1, 1]", "limits: [-1e300, 1e300]", ""),
    "a drive's limit": (MODEL, "{velocity_limit: 1}", "{velocity_limit: 1e300}", MODEL),
    "a laser's range": (MODEL, "range: 10", "range: 1e300", MODEL),
    "a laser's origin": (MODEL, "range: 10", "range: 10\n    origin: [1e300, 0, 0]", MODEL),
}


@pytest.fixture
def spoilt(good_files):
    """A folder with a world that loads, and with files that could not be part of one."""
    (good_files.folder / "folder").mkdir()
    image = (good_files.folder / "map.png").read_bytes()
    middle = len(image) // 2
    good_files.write("cut.png", image[:middle])
    good_files.write("corrupt.png", image[:middle] + bytes(8) + image[middle + 8 :])
    good_files.write("empty.png", b"")
    good_files.write("ping.yaml", "x: $include pong.yaml\n")
    good_files.write("pong.yaml", "y: $include ping.yaml\n")
    good_files.write("two.yaml", "name: first\n---\nnaem: second\n")
    good_files.write("empty.yaml", "")
    good_files.write("short_pose.yaml", b"\n[1, 2]\n")
    return good_files


def test_the_files_are_good_before_they_are_spoilt(spoilt):
    world = spoilt.load()

    assert [layer.name for layer in world.layers] == ["map", "lines", "floor"]
    assert world.plugin_count == 2
    world.close()


@pytest.mark.parametrize(("file", "old", "new", "message"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_file_is_answered_by_what_is_wrong_and_where(spoilt, file, old, new, message):
    if old is None:
        (spoilt.folder / file).write_bytes(new if isinstance(new, bytes) else new.encode())
    else:
        spoilt.edit(file, old, new)

    assert spoilt.refusal() == message


@pytest.mark.parametrize(("file", "old", "new", "fault"), TOO_MUCH.values(), ids=TOO_MUCH.keys())
def test_a_number_that_is_too_much_for_physics_is_refused(spoilt, file, old, new, fault):
    spoilt.edit(file, old, new)

    assert spoilt.refusal().startswith(fault)


def test_a_world_that_is_not_there_is_named(files):
    assert files.refusal() == "world.yaml: cannot be read: No such file or directory"


def test_a_world_that_is_a_folder_is_named(files):
    (files.folder / "world.yaml").mkdir()

    assert files.refusal() == "world.yaml: cannot be read: Is a directory"


@pytest.mark.parametrize(
    ("old", "new"),
    [("map: map.yaml", "map: {}"), ("model: robot", "model: {}"), ("[1, 2, 0.5]", "$include {}")],
)
def test_a_file_name_that_is_too_long_is_not_there(good_files, old, new):
    name = "a" * 300
    good_files.edit("world.yaml", old, new.format(name))

    message = good_files.refusal()

    assert message.startswith("world.yaml:")
    assert name in message


def test_a_list_for_a_merge_key_is_refused(good_files):
    good_files.edit("world.yaml", "- name: floor", "- {name: floor, <<: {[color]: 2}}")

    assert good_files.refusal().startswith("world.yaml:8: ")


def bomb(kind: str) -> str:
    """Nine times nine times nine ... of something."""
    levels = ["x0: &x0 {k: 1}" if kind != "lists" else "x0: &x0 [1]"]
    for i in range(1, 9):
        nine = [f"*x{i - 1}"] * 9
        if kind == "lists":
            value = f"[{', '.join(nine)}]"
        elif kind == "maps":
            value = f"{{{', '.join(f'{key}: {item}' for key, item in zip('abcdefghi', nine))}}}"
        else:
            value = f"{{k{i}: 1, <<: [{', '.join(nine)}]}}"
        levels.append(f"x{i}: &x{i} {value}")
    return "\n".join(levels)


@pytest.mark.parametrize(
    ("kind", "key"),
    [
        *(("lists", key) for key in ("x", "properties", "layers", "models")),
        *(("maps", key) for key in ("x", "properties", "layers")),
        ("merged maps", "x"),
    ],
)
def test_an_alias_bomb_is_answered_at_once(files, kind, key):
    files.write("world.yaml", f"{bomb(kind)}\n{key}: *x8\n")

    begin = time.monotonic()
    message = files.refusal()

    assert time.monotonic() - begin < 1.0
    assert 'world.yaml:1: unknown key "x0"' in message.splitlines()
    assert len(message) < 5_000


def test_an_include_bomb_is_answered_at_once(files):
    files.write("world.yaml", "properties: {}\nlayers: []\nx: $include 0.yaml\n")
    for i in range(5):
        files.write(f"{i}.yaml", f"[{', '.join([f'$include {i + 1}.yaml'] * 9)}]\n")
    files.write("5.yaml", "1\n")

    begin = time.monotonic()
    files.refusal()

    assert time.monotonic() - begin < 2.0


def test_problems_of_several_files_are_reported_together(good_files):
    good_files.edit("world.yaml", "velocity_iterations: 10", "velocity_iterations: 0")
    good_files.edit("world.yaml", "[0.4, 0.4, 0.4, 1]", "grey")
    good_files.edit("world.yaml", "pose: [1, 2, 0.5]", "pose: [1, 2]")
    good_files.edit("map.yaml", "resolution: 0.05", "resolution: 0")
    good_files.edit("map.yaml", "map.png", "office.png")
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: -0.5")
    good_files.edit("robot.model.yaml", "collide_connected: false", "collide_connectd: false")
    good_files.edit("robot.model.yaml", "name: laser", "name: drive")
    good_files.edit("lines.dat", "2 3 -1 2", "2 3 -1")

    assert good_files.refusal().splitlines() == [
        "world.yaml:1: properties.velocity_iterations: expected a whole number of 1 or more, "
        "found 0",
        'world.yaml:5: layers[0].color: expected [r, g, b, alpha], found "grey"',
        "map.yaml:2: resolution: expected a number above 0, found 0",
        "map.yaml:1: image: expected a file, but office.png is not there",
        'lines.dat:2: expected "x1 y1 x2 y2", found "2 3 -1"',
        "world.yaml:12: models[0].pose: expected [x, y, yaw], found [1, 2]",
        "robot.model.yaml:11: bodies[0].footprints[0].radius: "
        "expected a number above 0, found -0.5",
        'robot.model.yaml:28: joints[0] "hinge": unknown key "collide_connectd" '
        '(did you mean "collide_connected"?)',
        'robot.model.yaml:47: plugins[1].name: the name "drive" is given twice',
    ]


def test_problems_of_all_plugins_are_reported_together(good_files):
    good_files.edit("robot.model.yaml", "velocity_limit", "velocity_limt")
    good_files.edit("robot.model.yaml", "range: 10", "range: 0")
    good_files.edit("robot.model.yaml", "min: -1", "min: left")

    assert good_files.refusal().splitlines() == [
        'robot.model.yaml:45: plugins[0].linear_dynamics: unknown key "velocity_limt" '
        '(did you mean "velocity_limit"?)',
        'robot.model.yaml:50: plugins[1].angle.min: expected a number, found "left"',
        "robot.model.yaml:49: plugins[1].range: expected a number above 0, found 0",
    ]


def test_an_error_knows_file_line_and_column_of_what_is_wrong(good_files):
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: none")

    with pytest.raises(YamlError) as caught:
        good_files.load()

    assert isinstance(caught.value, FlatlandError)
    assert caught.value.file == good_files.folder / "robot.model.yaml"
    assert (caught.value.line, caught.value.column) == (11, 17)
