"""The command `flatland check`, without a ROS master and rospy: summaries, problems, pictures."""

import contextlib
import io
import re
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from PIL import Image

from flatland2d.cli import main

WITHOUT_ROSPY = """
import sys

class Blockade:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("rospy", "rosgraph", "tf2_ros"):
            raise ImportError(f"{name} is blocked")

sys.meta_path.insert(0, Blockade())
from flatland2d.cli import main
sys.exit(main(["check", *sys.argv[1:]]))
"""


@pytest.fixture
def check(files, monkeypatch):
    """Runs `flatland check` in this process, on files of the folder."""
    monkeypatch.chdir(files.folder)

    def check(*arguments: str) -> "subprocess.CompletedProcess[str]":
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            try:
                code: Any = main(["check", *arguments])
            except SystemExit as error:
                code = error.code
        return subprocess.CompletedProcess(arguments, code, output.getvalue(), errors.getvalue())

    return check


@pytest.fixture
def check_alone(files):
    """Runs `flatland check` as a command, with its log; rospy cannot be imported."""

    def check(*arguments: str) -> "subprocess.CompletedProcess[str]":
        command = [sys.executable, "-c", WITHOUT_ROSPY, *arguments]
        return subprocess.run(command, cwd=files.folder, capture_output=True, text=True, timeout=60)

    return check


def assert_answer(answer, code: int, output: str = "", errors: str = "") -> None:
    assert (answer.stdout, answer.stderr, answer.returncode) == (output, errors, code)


def test_a_good_world_is_summed_up_in_a_line(good_files, check_alone):
    world = good_files.load()
    world.close()
    count = sum(len(layer.segments) for layer in world.layers)

    summary = f"3 layers, {count} segments, 1 model, 2 bodies, 2 plugins"
    assert_answer(check_alone("world.yaml"), 0, f"world.yaml: {summary}\n")


def test_all_problems_are_printed_with_line_and_column(good_files, check):
    good_files.edit("world.yaml", "[0.4, 0.4, 0.4, 1]", "grey")
    good_files.edit("world.yaml", "pose: [1, 2, 0.5]", "pose: [1, 2]")
    good_files.edit("map.yaml", "map.png", "office.png")
    good_files.edit("lines.dat", "2 3 -1 2", "2 3 -1")
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: -0.5")
    good_files.edit("robot.model.yaml", "collide_connected: false", "collide_connectd: false")

    answer = check("world.yaml")

    assert answer.stdout == ""
    assert answer.returncode == 1
    assert answer.stderr.splitlines() == [
        'world.yaml:5:12: layers[0].color: expected [r, g, b, alpha], each 0 to 1, found "grey"',
        "map.yaml:1:8: image: expected a file, but office.png is not there",
        'lines.dat:2: expected four numbers, x1 y1 x2 y2, found "2 3 -1"',
        "world.yaml:12:11: models[0].pose: expected [x, y, yaw], found [1, 2]",
        "robot.model.yaml:11:17: bodies[0].footprints[0].radius: "
        "expected a number above 0, found -0.5",
        'robot.model.yaml:28:5: joints[0] "hinge": unknown key "collide_connectd" '
        '(did you mean "collide_connected"?)',
    ]


@pytest.mark.parametrize("file", ["world.yaml", "robot.model.yaml"])
def test_problems_of_footprints_and_plugins_come_together(good_files, check, file):
    good_files.edit("robot.model.yaml", "radius: 0.5", "radius: -1")
    good_files.edit("robot.model.yaml", "range: 10", "raneg: 10")

    answer = check(file)

    assert answer.returncode == 1
    assert answer.stderr.splitlines() == [
        "robot.model.yaml:11:17: bodies[0].footprints[0].radius: "
        "expected a number above 0, found -1",
        'robot.model.yaml:46:5: plugins[1] "laser": the required key "range" is missing',
        'robot.model.yaml:49:5: plugins[1] "laser": unknown key "raneg" (did you mean "range"?)',
    ]


def test_a_map_alone_is_checked_as_a_map(good_files, check):
    lines = "{{type: line_segments, data: {}.dat, scale: 2, origin: [5, 5, 0]}}"
    for name, walls in (("scaled", "0 0 4 0\n4 0 4 3"), ("empty", "")):
        good_files.write(f"{name}.dat", walls)
        good_files.write(f"{name}.yaml", lines.format(name))
    world = good_files.load()
    [image] = [each for each in world.layers if each.config.map == good_files.folder / "map.yaml"]
    width, height = np.ptp(image.segments.reshape(-1, 2), axis=0)
    count = len(image.segments)
    world.close()
    good_files.write(
        "wrong.yaml", (good_files.folder / "map.yaml").read_text().replace("map.", "o.")
    )

    assert_answer(
        check("map.yaml", "scaled.yaml", "empty.yaml", "wrong.yaml"),
        1,
        f"map.yaml: a map of {count} segments, {width:.4g} x {height:.4g} m\n"
        "scaled.yaml: a map of 2 segments, 8 x 6 m\n"
        "empty.yaml: a map of 0 segments, 0 x 0 m\n",
        "wrong.yaml:1:8: image: expected a file, but o.png is not there\n",
    )


def test_a_map_alone_has_a_picture(good_files, check):
    assert check("map.yaml", "--render", "map_picture.png").returncode == 0

    with Image.open(good_files.folder / "map_picture.png") as image:
        assert max(image.size) == 1600
        assert (102, 102, 102) in [color for _, color in image.convert("RGB").getcolors(1 << 24)]


def test_a_file_that_is_neither_is_told_what_it_lacks(files, check):
    files.write("other.yaml", "rate: 5\nname: other\n")

    assert_answer(
        check("other.yaml"),
        1,
        "",
        'other.yaml:1:1: expected a world, which has the keys "properties" and "layers", a model '
        '("bodies"), or a map ("image" or "data", "resolution" or "scale", "origin"); found none '
        "of these keys\n",
    )


def test_one_wrong_file_of_several_fails_the_check(good_files, check):
    good_files.write("broken.yaml", "properties: {}\n")

    answer = check("test_room", "robot.model.yaml", "broken.yaml", "missing.yaml")

    assert answer.returncode == 1
    room, model = answer.stdout.splitlines()  # of a model alone, plugins may name any layer
    assert "/test_room/world.yaml: 1 layer, 4 segments, " in room
    assert model == "robot.model.yaml: 0 layers, 0 segments, 1 model, 2 bodies, 2 plugins"
    assert answer.stderr.splitlines() == [
        'broken.yaml:1:1: the required key "layers" is missing',
        "missing.yaml: cannot be read: No such file or directory",
    ]


@pytest.mark.parametrize("file", ["lines.dat", "map.png", "."])
def test_a_file_of_another_kind_is_refused_without_a_traceback(good_files, check, file):
    answer = check(file)

    assert (answer.returncode, answer.stdout) == (1, "")
    assert answer.stderr
    assert "Traceback" not in answer.stderr


def test_a_warning_of_an_expression_does_not_fail_the_check(good_files, check_alone):
    good_files.edit("world.yaml", "namespace: r1", "namespace: $eval env('NOT_SET_AT_ALL')")

    answer = check_alone("world.yaml")

    assert answer.returncode == 0
    assert answer.stderr == (
        'world.yaml:11: the environment variable "NOT_SET_AT_ALL" is not set and has no default; '
        "a blank string is used\n"
    )


# Pictures


def test_a_picture_shows_walls_footprints_and_names(files, check):
    files.write("lines.dat", "0 0 10 0\n10 0 10 10\n10 10 0 10\n0 10 0 0\n")
    files.write("map.yaml", "{type: line_segments, data: lines.dat, scale: 1, origin: [0, 0, 0]}")
    files.write(
        "disc.yaml",
        "bodies: [{name: base, color: [1, 0, 0, 1], "
        "footprints: [{type: circle, radius: 1, density: 1}]}]",
    )
    files.write(
        "world.yaml",
        """
        properties: {}
        layers: [{name: map, map: map.yaml, color: [0, 0, 1, 1]}]
        models: [{name: disc, model: disc.yaml, pose: [7.5, 2.5, 0]}]
        """,
    )

    answer = check("world.yaml", "--render", "world.png")

    assert answer.returncode == 0, answer.stderr
    with Image.open(files.folder / "world.png") as image:
        assert image.format == "PNG"
        pixels = np.asarray(image.convert("RGB")).astype(int)
    height, width = pixels.shape[:2]
    assert width == height == 1600

    def where(color):
        return np.argwhere((abs(pixels - color) <= 3).all(axis=2))

    walls, discs, names = where((0, 0, 255)), where((255, 0, 0)), where((32, 32, 32))
    assert walls.min() < 60
    assert walls.max() > 1540
    # The disc is in the lower right: x to the right, y upwards.
    middle = discs.mean(axis=0)
    assert middle == pytest.approx((0.75 * 1520 + 40, 0.75 * 1520 + 40), abs=20)
    assert len(discs) == pytest.approx(np.pi * 152**2, rel=0.05)
    assert len(names) > 10
    assert abs(names.mean(axis=0) - middle).max() < 200


def test_a_name_is_readable_on_a_screen_and_beside_its_model(good_files, check):
    """Its letters are as tall in SVG, where the name is text."""
    answer = check("world.yaml", "--render", "world.svg")

    assert answer.returncode == 0, answer.stderr
    document = (good_files.folder / "world.svg").read_text()
    assert document.startswith("<svg ")
    sizes = re.findall(r'<text [^>]*font-size="(\d+)"', document)
    assert sizes
    assert min(map(int, sizes)) >= 16


def test_an_empty_world_has_a_picture_but_a_wrong_one_has_none(files, check):
    for text, code in (("{properties: {}, layers: []}", 0), ("{properties: {}}", 1)):
        files.write("world.yaml", text)
        assert check("world.yaml", "--render", f"{code}.png").returncode == code
        assert (files.folder / f"{code}.png").is_file() == (code == 0)


def test_an_unwritable_picture_is_an_error_without_a_traceback(good_files, check_alone):
    answer = check_alone("world.yaml", "--render", "no/such/folder/world.png")

    assert answer.returncode != 0
    assert "Traceback" not in answer.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "usage: flatland check"),
        (["world.yaml", "a.yaml", "--render", "world.png"], "--render takes a single FILE"),
    ],
)
def test_wrong_arguments_end_with_2(check, arguments, message):
    answer = check(*arguments)

    assert answer.returncode == 2
    assert message in answer.stderr
