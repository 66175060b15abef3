"""Wrong YAML syntax, includes and expressions."""

from typing import Dict

from wrong_files.case import WORLD, Case

# fmt: off
WRONG_SYNTAX: Dict[str, Case] = {
    # YAML
    "an empty file": (WORLD, None, "", "world.yaml: expected a map, found an empty file"),
    "only comments": (WORLD, None, "# nothing\n# at all\n",
     "world.yaml: expected a map, found an empty file"),
    "null": (WORLD, None, "null\n", "world.yaml:1: expected a map, found nothing"),
    "a list for a world": (WORLD, None, "- properties: {}\n",
     "world.yaml:1: expected a map, found [a map]"),
    "a string for a world": (WORLD, None, "world\n", 'world.yaml:1: expected a map, found "world"'),
    "two documents": (WORLD, None, "properties: {}\n---\nlayers: []\n",
     "world.yaml:3: expected one document, found another one"),
    "a tab for indentation": (WORLD, None, "# Büro\nproperties: {}\nlayers:\n\t- name: map\n",
     "world.yaml:4: is not valid YAML: lines are indented by spaces, found a tab"),
    "a bracket that is not closed": (WORLD, "[1, 2, 0.5]", "[1, 2, 0.5",
     "world.yaml:13: is not valid YAML: while parsing a flow sequence from line 12 did not "
     "find expected ',' or ']'"),
    "a quote that is not closed": (WORLD, "namespace: r1", "namespace: 'r1",
     "world.yaml:14: is not valid YAML: while scanning a quoted scalar from line 11 found "
     "unexpected end of stream"),
    "wrong indentation": (WORLD, "    pose:", "   pose:",
     "world.yaml:12: is not valid YAML: expected the indentation of the list or map from line 10"),
    "a key farther to the right": (WORLD, "    pose:", "      pose:",
     "world.yaml:12: is not valid YAML: expected the key in the column of the one before it, found "
     "it to the right"),
    "a colon in a text": (WORLD, "name: floor", "name: ground: floor",
     'world.yaml:8: is not valid YAML: expected quotes around a text with ": " in it'),
    "no space after a colon": (WORLD, "    pose: [1, 2, 0.5]", "    pose:[1, 2, 0.5]",
     'world.yaml:12: is not valid YAML: expected "key: value", a space after the colon, found '
     '"pose:[1, 2, 0.5]"'),
    "a text after a list": (WORLD, "[1, 2, 0.5]", "[1, 2, 0.5] m",
     'world.yaml:12: is not valid YAML: expected the end of the line, found "m"'),
    "a key without a colon": (WORLD, None, "properties\nlayers: []\n",
     'world.yaml:1: is not valid YAML: expected "key: value", found "properties"'),
    "a text that begins with a sign": (WORLD, "name: robot", "name: @robot",
     "world.yaml:10: is not valid YAML: expected quotes around a text that begins with @"),
    "indentation by another space": (WORLD, "    pose:", "  \u00a0 pose:",
     "world.yaml:12: is not valid YAML: lines are indented by spaces, found the character U+00A0"),
    "an unknown alias": (WORLD, "[1, 2, 0.5]", "*here",
     "world.yaml:12: is not valid YAML: found undefined alias"),
    "a control character": (WORLD, None, b"properties: {}\x07\n",
     "world.yaml: is not valid YAML: unacceptable character #x0007: control "
     "characters are not allowed"),
    "not UTF-8": (WORLD, None, b"properties: {}\nlayers: [{name: caf\xe9}]\n",
     "world.yaml:2: is not UTF-8 text: found the byte 0xE9"),
    "ten thousand brackets": (WORLD, None, "properties: " + "[" * 10_000 + "]" * 10_000,
     "world.yaml:1: expected at most 100 levels, found more"),
    "an anchor that contains itself": (WORLD, None, "properties: {}\nlayers: &all\n  - *all\n",
     "world.yaml:2: contains itself"),
    "a map that contains itself": (WORLD, None, "&world\nproperties: *world\nlayers: []\n",
     "world.yaml:1: contains itself"),
    "a merged string": (WORLD, None, "properties: {}\n<<: layers\n",
     "world.yaml:2: expected a map or a list of maps after <<"),
    "a key that begins with another space": (WORLD, None,
     "properties: {}\n\u00a0\u00a0layers: []\nlayers: []\n",
     'world.yaml:2: unknown key "layers" (lines are indented by spaces, found the character '
     "U+00A0)"),
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
    "bad Lua": (WORLD, "[1, 2, 0.5]", "$eval 1 +",
     "world.yaml:12: $eval: unexpected symbol near '1', in: 1 +"),
    "Lua that fails": (WORLD, "[1, 2, 0.5]", "\"$eval error('not today')\"",
     "world.yaml:12: $eval: not today, in: error('not today')"),
    "Lua that eats memory": (WORLD, "[1, 2, 0.5]", '$eval ("x"):rep(2^31 - 1)',
     'world.yaml:12: $eval: not enough memory, in: ("x"):rep(2^31 - 1)'),
    "a result of the wrong type": (WORLD, "[1, 2, 0.5]", "$eval 1 + 1",
     "world.yaml:12: models[0].pose: expected [x, y, yaw], found 2"),
    "a table with gaps": (WORLD, "[1, 2, 0.5]", '"$eval {1, 2, nil, 4}"',
     "world.yaml:12: $eval: expected a table with keys 1, 2, 3 ..., found gaps, in: "
     "{1, 2, nil, 4}"),
    "a parameter that is not set": (WORLD, "[1, 2, 0.5]", "$eval param('/pose')",
     'world.yaml:12: models[0].pose: expected [x, y, yaw], found ""'),
}
# fmt: on
