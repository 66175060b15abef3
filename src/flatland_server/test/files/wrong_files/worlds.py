"""Wrong world files: properties, layers, and entries of models."""

from typing import Dict

from wrong_files.case import PLUGINS, WORLD, Case

# fmt: off
WRONG_WORLDS: Dict[str, Case] = {
    # The world
    "no properties": (WORLD, "properties: {velocity_iterations: 10, position_iterations: 10}\n",
     "", 'world.yaml:1: the required key "properties" is missing'),
    "a string for properties": (WORLD, "{velocity_iterations: 10, position_iterations: 10}", "fast",
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
    "nothing for layers": (WORLD, None, "properties:\nlayers:\n# - name: map\n",
     'world.yaml:2: the required key "layers" has no value'),
    "a map for layers": (WORLD, None, "properties: {}\nlayers: {name: map}\n",
     "world.yaml:2: layers: expected a list, found a map"),
    "a string for a layer": (WORLD, "{name: lines, map: lines.yaml}", "lines.yaml",
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
     "world.yaml:8: layers[2].name: expected a string, found a map"),
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
    "too bright a colour": (WORLD, "color: [0.4, 0.4, 0.4, 1]", "color: [255, 255, 255, 1]",
     "world.yaml:5: layers[0].color: expected [r, g, b, alpha], each 0 to 1, found "
     "[255, 255, 255, 1]"),
    "an unknown key of a layer": (WORLD, "color: [0.4", "colour: [0.4",
     'world.yaml:5: layers[0]: unknown key "colour" (did you mean "color"?)'),
    "an unknown key of a layer's properties": (WORLD, "{min_z: 0, max_z: 1}", "{minz: 0}",
     'world.yaml:6: layers[0].properties.debug: unknown key "minz" (did you mean "min_z"?)'),
    "an unknown section of a layer's properties": (WORLD, "{debug: {", "{debgu: {",
     'world.yaml:6: layers[0].properties: unknown key "debgu" (did you mean "debug"?)'),
    "a map that is not there": (WORLD, "map: map.yaml", "map: office.yaml",
     "world.yaml:4: layers[0].map: expected a file, but office.yaml is not there"),
    "a map in capitals": (WORLD, "map: map.yaml", "map: Map.YAML",
     "world.yaml:4: layers[0].map: expected a file, but Map.YAML is not there (did you mean "
     '"map.yaml"?)'),
    "a map of another extension": (WORLD, "map: lines.yaml", "map: lines.yml",
     "world.yaml:7: layers[1].map: expected a file, but lines.yml is not there (did you mean "
     '"lines.yaml"?)'),
    "a map as in a launch file": (WORLD, "map: map.yaml", "map: $(find my_maps)/map.yaml",
     'world.yaml:4: layers[0].map: expected package://name/path, found "$(find my_maps)/map.yaml"'),
    "an image for a map": (WORLD, "map: map.yaml", "map: map.PNG",
     'world.yaml:4: layers[0].map: expected a YAML file that names the image, found "map.PNG"'),
    "a map that is a folder": (WORLD, "map: map.yaml", "map: folder",
     "world.yaml:4: layers[0].map: expected a file, but folder is a folder"),
    "a list for a map": (WORLD, "map: map.yaml", "map: [map.yaml]",
     'world.yaml:4: layers[0].map: expected a string, found ["map.yaml"]'),
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
    "a pose beyond all maps": (WORLD, "pose: [1, 2, 0.5]", "pose: [1.0e+12, 2, 0.5]",
     "world.yaml:12: models[0].pose: expected [x, y, yaw], numbers within 1e+09 of zero, found "
     "[1.0e+12, 2, 0.5]"),
    "NaN in a pose": (WORLD, "pose: [1, 2, 0.5]", "pose: [1, 2, .nan]",
     "world.yaml:12: models[0].pose: expected [x, y, yaw], found [1, 2, .nan]"),
    "no file of a model": (WORLD, "    model: robot.model.yaml\n", "",
     'world.yaml:10: models[0] "robot": the required key "model" is missing'),
    "a model that is not there": (WORLD, "robot.model.yaml", "robto.model.yaml",
     "world.yaml:13: models[0].model: expected a file, but robto.model.yaml is not there (did "
     'you mean "robot.model.yaml"?)'),
    "an unknown key of an entry": (WORLD, "pose:", "position:",
     'world.yaml:12: models[0] "robot": unknown key "position"'),
    "a plugin of the world that is unknown": (WORLD, "models:",
     "plugins: [{type: Weather, name: rain}]\nmodels:",
     'world.yaml:9: plugins[0].type: unknown plugin type "Weather"; there are: '
     + PLUGINS),
    "a model's plugin in the world": (WORLD, "models:",
     "plugins: [{type: Laser, name: eye}]\nmodels:",
     'world.yaml:9: plugins[0].type: "Laser" is not a WorldPlugin: '
     "flatland_plugins.laser.Laser"),
}
# fmt: on
