"""The command flatland: what it prints and writes, its exit codes, and that Ctrl-C ends it well."""

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

from flatland2d.cli import main

pytestmark = pytest.mark.slow

PAGE = Path(__file__).resolve().parents[3] / "docs" / "command_line.md"
ROBOT = """
bodies: [{name: base, footprints: [{type: circle, radius: 0.2, density: 1}]}]
plugins:
  - {type: DiffDrive, name: drive, body: base}
  - {type: Laser, name: laser, body: base, range: 5, angle: {min: -1, max: 1, increment: 0.5}}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a world of one robot, and a map with a slanted wall; the working directory."""
    (tmp_path / "robot.model.yaml").write_text(ROBOT)
    (tmp_path / "world.yaml").write_text(
        "properties: {}\nlayers: []\nmodels: [{name: robot, model: robot.model.yaml}]\n"
    )
    image = Image.new("L", (60, 60), 255)
    for column in range(10, 50):
        image.putpixel((column, column // 2), 0)
    image.save(tmp_path / "map.png")
    (tmp_path / "map.yaml").write_text(
        "image: map.png\nresolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n"
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


FLATLAND = f"{shlex.quote(sys.executable)} -m flatland2d"


def in_shell(command):
    return subprocess.run(command, shell=True, capture_output=True, text=True)


def test_the_shipped_worlds_are_listed(capsys):
    assert main(["worlds"]) == 0

    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()]
    names = (
        "circle_crossing corridor_frontal crossing doorway intersection office overtaking "
        "racetrack test_room"
    )
    assert [name for name, _ in lines] == names.split()
    assert all(Path(path).is_file() for _, path in lines)


def test_a_map_becomes_lines(folder, capsys):
    assert main(["map_to_lines", "map.yaml", "--picture", "both.png"]) == 0
    assert re.fullmatch(
        r"map_lines\.yaml: \d+ lines for \d+ segments of outlines, at most 0\.\d+ m apart\n",
        capsys.readouterr().out,
    )
    (folder / "lined.yaml").write_text(
        "properties: {}\nlayers: [{name: walls, map: map_lines.yaml}]\nmodels: []\n"
    )
    assert main(["check", "lined.yaml"]) == 0
    colors = {color for _, color in Image.open("both.png").getcolors(1 << 20)}
    assert {(204, 38, 26), (26, 51, 153)} <= colors  # lines and their ends

    assert main(["map_to_lines", "map_lines.yaml"]) == 1
    assert 'type: expected image, found "line_segments"' in capsys.readouterr().err
    assert main(["map_to_lines", "map.yaml", "-o", "lines.dat"]) == 1
    assert "lines.dat: expected the name of a YAML file" in capsys.readouterr().err
    assert main(["map_to_lines", "map.yaml", "-o", "map.yaml"]) == 1
    assert "map.yaml: is the map itself" in capsys.readouterr().err


def test_a_parameter_reaches_expressions_and_plugins(folder, capsys):
    robot = (folder / "robot.model.yaml").read_text()
    (folder / "robot.model.yaml").write_text(
        robot.replace("range: 5", "range: $eval param('/lidar/range')")
    )
    for command in (
        "check world.yaml",
        "run world.yaml --seconds 0.1",
        "render world.yaml -o w.png",
    ):
        assert main([*command.split(), "--param", "lidar/range=5.5"]) == 0, command
        assert main([*command.split(), "--param", "lidar/range:=far"]) == 1
        assert 'range: expected a number, found "far"' in capsys.readouterr().err

    with pytest.raises(SystemExit):
        main(["run", "world.yaml", "--param", "lidar/range"])
    assert 'expected NAME=VALUE with a value in YAML, found "lidar/range"' in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize("command", ["run", "render"])
def test_a_wrong_world_is_told_without_a_traceback(folder, capsys, command):
    (folder / "world.yaml").write_text("properties: {}\nlayers: []\nmodles: []\n")
    more = ["--seconds", "1"] if command == "run" else ["-o", "world.png"]

    assert main([command, "world.yaml", *more]) == 1
    assert main([command, "ofice", *more]) == 1

    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith(f"{folder}/world.yaml:3:1: ") or first.startswith("world.yaml:3:1: ")
    assert 'did you mean "office"?' in second
    assert not (folder / "world.png").exists()


def test_a_world_is_drawn(folder):
    arguments = ["render", "world.yaml", "-o", "world.png", "--size", "320x200", "--names"]
    assert main([*arguments, "--sensors", "--time", "0.5"]) == 0
    assert main(["render", "world.yaml", "-o", "near.svg", "--follow", "robot"]) == 0

    with Image.open("world.png") as image:
        assert image.size == (320, 200)
    assert Path("near.svg").read_text().startswith("<svg")


def test_the_way_of_a_model_is_drawn(folder, capsys):
    tween = "{type: Tween, name: tween, body: base, mode: loop, delta: [1, 0, 0], duration: 1}"
    (folder / "robot.model.yaml").write_text(f"{ROBOT}  - {tween}\n")
    arguments = ["render", "world.yaml", "-o", "way.svg", "--time", "0.5"]

    assert main(arguments) == 0
    without = Path("way.svg").read_text()
    assert main([*arguments, "--trail", "robot"]) == 0
    lines = [
        re.findall(r"[-0-9.]+,[-0-9.]+", line)
        for line in set(Path("way.svg").read_text().split("<")) - set(without.split("<"))
    ]
    assert len(lines) == 2  # of the robot, and of its odometry
    assert min(map(len, lines)) > 5
    assert main([*arguments, "--trail", "robt"]) == 1
    assert 'did you mean "robot"' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--follow", "robt"], 'no model "robt" (did you mean "robot"?)'),
        (["-o", "world.xyz"], "unknown file extension: .xyz"),
        (["-o", "no/such/folder.png"], "cannot be written: No such file or directory\n"),
        (["--size", "0x10"], "expected a width and a height of 1 to 16384 pixels"),
    ],
)
def test_a_picture_that_cannot_be_made_is_one_line(folder, capsys, arguments, message):
    assert main(["render", "world.yaml", "-o", "world.png", *arguments]) == 1

    error = capsys.readouterr().err
    assert message in error
    assert error.startswith("flatland: ")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        *(f"run world.yaml --seconds {value}" for value in ("-1", "nan", "1e308")),
        "render world.yaml -o a.png --time 1e308",
        *(f"sweep scenarios.yaml --tolerance {value}" for value in ("nan", "-1")),
        *(f"run world.yaml --seed {value}" for value in ("1.5", "inf")),
        "run world.yaml --topics /scan",
        "run world.yaml --duration 2",
        "render world.yaml",
        "render world.yaml -o a.png --size big",
        "fly",
        "",
    ],
)
def test_arguments_that_it_does_not_know_end_with_2(folder, capsys, arguments):
    with pytest.raises(SystemExit) as error:
        main(arguments.split())

    assert error.value.code == 2
    command = arguments.partition(" ")[0].replace("fly", "")
    assert f"usage: flatland {command}" in capsys.readouterr().err


def test_a_run_ends_with_a_summary(folder, capsys):
    seed = "9007199254740993"  # more digits than a float has
    assert main(["run", "world.yaml", "--seconds", "2", "--seed", seed, "--step-size", "0.01"]) == 0

    output = capsys.readouterr()
    assert output.out.startswith("world.yaml: 2 s in ")
    assert output.out.endswith(f" times real time (200 steps of 0.01 s, seed {seed})\n")
    assert output.err == ""


def test_a_run_keeps_to_a_rate(folder, capsys):
    assert main(["run", "world.yaml", "--seconds", "0.5", "--rate", "2"]) == 0

    words = capsys.readouterr().out.split()
    assert float(words[4]) == pytest.approx(0.25, abs=0.1)


def test_progress_is_shown_if_asked(folder, capsys):
    pytest.importorskip("tqdm")
    assert main(["run", "world.yaml", "--seconds", "2", "--progress"]) == 0

    error = capsys.readouterr().err
    assert "100%" in error
    assert "2.0/2.0 s" in error
    assert "x real time" in error


def test_a_plugin_that_fails_is_reported_in_the_end(folder, capsys, monkeypatch):
    monkeypatch.setattr("flatland_plugins.laser.Laser.has_work", lambda self: 1 / 0)

    assert main(["run", "world.yaml", "--seconds", "0.1"]) == 1

    output = capsys.readouterr()
    assert "0.1 s in" in output.out
    assert output.err.splitlines()[-1].startswith('the plugin "robot/laser" failed in has_work')


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "number", "code"),
    [
        ([], signal.SIGINT, 0),
        (["--seconds", "1e6"], signal.SIGINT, 130),
        (["--rate", "1"], signal.SIGTERM, 0),
        (["--rate", "1"], signal.SIGHUP, 0),
    ],
)
def test_ctrl_c_ends_a_run_with_what_was_done(folder, arguments, number, code):
    process = subprocess.Popen(
        [sys.executable, "-m", "flatland2d", "run", "world.yaml", "--progress", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert process.stderr.read(1)  # the progress bar: it runs
    os.kill(process.pid, number)
    output, error = process.communicate(timeout=60)

    assert process.returncode == code, error
    assert output.decode().startswith("world.yaml: ")
    assert b"Traceback" not in error


@pytest.mark.slow
@pytest.mark.parametrize("arguments", ["worlds", "run world.yaml --seconds 0.1", "--version"])
@pytest.mark.parametrize(
    ("output", "reason"), [(">&-", "it is closed"), ("> /dev/full", "No space left on device")]
)
def test_an_unwritable_output_is_one_line_and_exit_code_1(folder, arguments, output, reason):
    if (arguments, output) == ("--version", ">&-"):
        pytest.skip("argparse prints it on standard error then")

    answer = in_shell(f"{FLATLAND} {arguments} {output}")

    assert answer.stderr == f"flatland: the output cannot be written: {reason}\n"
    assert answer.returncode == 1


def test_a_run_without_standard_error_is_a_run(folder):
    answer = in_shell(f"{FLATLAND} run world.yaml --seconds 0.1 2>&-")

    assert (answer.stdout.count("times real time"), answer.returncode) == (1, 0)


def test_a_folder_that_is_gone_is_one_line(folder):
    (folder / "gone").mkdir()

    answer = in_shell(f"cd gone && rmdir ../gone && {FLATLAND} sweep scenarios.yaml")

    assert answer.stderr == "flatland: the working directory is not there\n"
    assert answer.returncode == 1


@pytest.mark.parametrize("name", ["run.bag", "run.mcap"])
def test_a_run_is_recorded(folder, capsys, name):
    arguments = ["run", "world.yaml", "--seconds", "1", "--record", name, "--topics", "/scan"]
    assert main([*arguments, "/tf", "scna"]) == 0

    out, error = capsys.readouterr()
    assert out.splitlines()[1] == f"recorded in {name}"
    assert error == 'no plugin has a topic "/scna" to record (did you mean "/scan"?)\n'
    assert Path(name).stat().st_size > 1000
    assert [path.name for path in folder.glob(f"{name}*")] == [name]


def test_a_recording_of_another_kind_is_an_error(folder, capsys):
    assert main(["run", "world.yaml", "--seconds", "1", "--record", "run.csv"]) == 1

    error = capsys.readouterr().err
    assert ".bag" in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_ctrl_c_completes_the_recording(folder):
    rosbag = pytest.importorskip("rosbag")
    arguments = ["run", "world.yaml", "--rate", "1", "--progress"]
    arguments += ["--record", "run.bag", "--topics", "/scan"]
    process = subprocess.Popen(
        [sys.executable, "-m", "flatland2d", *arguments], stderr=subprocess.PIPE
    )
    while b"0.2 s" not in process.stderr.read1(1000):
        assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)

    assert process.returncode == 0
    with rosbag.Bag("run.bag") as bag:
        assert bag.get_message_count("/scan") >= 40


@pytest.mark.slow
def test_rosrun_finds_it_and_returns_its_exit_code(folder):
    answer = in_shell("rosrun flatland2d flatland check gone.yaml")

    assert answer.stderr == "gone.yaml: cannot be read: No such file or directory\n"
    assert answer.returncode == 1


@pytest.mark.slow
def test_a_closed_pipe_is_no_traceback(folder):
    assert in_shell(f"{FLATLAND} worlds | true").stderr == ""


# docs/command_line.md


def options_in(text):
    return set(re.findall(r"(?<![\w-])--?[a-z][a-z-]*", text))


@pytest.mark.parametrize("command", ["render", "run", "view"])
def test_the_page_has_all_options(command, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    options = options_in(capsys.readouterr().out) - {"-h", "--help"}
    text = re.sub(r"```.*?```", "", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    common, *sections = re.split(r"^## ", text, flags=re.MULTILINE)
    [section] = [each for each in sections if each.startswith(f"{command}\n")]

    assert options == options_in(section + common.partition("have these:")[2])
