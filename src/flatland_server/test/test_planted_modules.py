"""Modules in the working directory are not imported, whatever is started there."""

import os
import subprocess
from pathlib import Path

import pytest
from ros_processes import executable

ROOT = Path(__file__).resolve().parents[3]

pytestmark = pytest.mark.slow

MODULES = ["PIL", "ctypes", "flatland_plugins", "flatland_server", "genpy", "json", "logging"]
MODULES += ["lupa", "numpy", "re", "resource", "rospkg", "rospy", "select", "subprocess", "yaml"]
WORLD = "properties: {velocity_iterations: $eval 5 + 5}\nlayers: [{name: map, map: map.yaml}]\n"
MAP = "{type: line_segments, data: lines.dat, scale: 1, origin: [0, 0, 0]}\n"


@pytest.fixture
def planted(tmp_path):
    """A world, among modules that leave a mark when they are imported."""
    folder = tmp_path / "planted"
    folder.mkdir()
    for module in MODULES:
        code = f"open({str(tmp_path / 'mark')!r}, 'a').write('{module} ')\n"
        (folder / f"{module}.py").write_text(code)
    (folder / "world.yaml").write_text(WORLD)
    (folder / "map.yaml").write_text(MAP)
    (folder / "lines.dat").write_text("0 0 1 1\n")
    yield folder
    mark = tmp_path / "mark"
    assert not mark.exists(), f"imported from the working directory: {mark.read_text()}"


def test_the_command_and_its_pictures(planted):
    flatland = executable("flatland2d", "flatland")
    command = [flatland, "check", "world.yaml", "--render", "world.png"]

    answer = subprocess.run(command, cwd=planted, capture_output=True, text=True, timeout=60)

    assert answer.returncode == 0, answer.stderr
    assert (planted / "world.png").exists()


def test_the_node(planted, master):
    node = subprocess.Popen(
        [executable("flatland_server", "flatland_server"), "_world_path:=world.yaml"],
        cwd=planted,
        env={**os.environ, "ROS_MASTER_URI": master.uri},
        stdout=subprocess.PIPE,
        text=True,
    )
    lines = []
    for line in node.stdout:  # ends when the node ends
        lines.append(line)
        if "running" in line:
            break
    node.terminate()
    node.communicate(timeout=30)
    assert "1 layer, 0 models; running" in "".join(lines)


def test_scripts_run(planted, monkeypatch, run, master):
    monkeypatch.chdir(planted)

    launch = run("world.yaml", "show_viz:=false", with_port=False, port=master.port)

    launch.wait_for("1 layer, 0 models; running")


def test_scripts_bench(planted):
    command = [str(ROOT / "scripts" / "bench"), "--list"]

    answer = subprocess.run(command, cwd=planted, capture_output=True, text=True, timeout=120)

    assert answer.returncode == 0, answer.stderr
