"""Worlds of BARN: read from files of its form, written as ours, and run."""

import math

import numpy as np
import pytest

from flatland2d import Simulation
from flatland2d.barn import GOAL, START, read_barn, write_barn
from flatland2d.cli import main
from flatland2d.sweep.runner import ScenarioRunner
from flatland2d.sweep.scenario_file import read_scenario_file
from flatland2d.sweep.settings import scenarios_of
from flatland_server.exceptions import FlatlandError

CYLINDER = """
<model name='unit_cylinder_{number}'>
  <static>1</static>
  <pose frame=''>{x} {y} 0.000000 0.000000 0.000000 0.000000</pose>
  <link name='link'>
    <collision name='collision'>
      <geometry><cylinder><radius>0.075000</radius><length>1</length></cylinder></geometry>
    </collision>
    <visual name='visual'>
      <geometry><cylinder><radius>0.5</radius><length>1</length></cylinder></geometry>
    </visual>
  </link>
</model>"""
PLANE = """
<model name='ground_plane'>
  <link name='link'><collision name='c'><geometry><plane/></geometry></collision></link>
</model>"""
PLACES = [(-0.075, 5.075), (-4.575, 5.075), (-2.25, 14.0)]
CELLS = np.array([[14, 0], [14, 28]])  # straight on, 0.075 m beside the start


def write_world(folder, number=3, places=PLACES):
    """A world as BARN's authors publish it: files in two folders."""
    for name in ("world_files", "path_files"):
        (folder / name).mkdir(exist_ok=True)
    cylinders = [CYLINDER.format(number=i, x=x, y=y) for i, (x, y) in enumerate(places)]
    text = f"<sdf version='1.6'><world name='default'>{PLANE}{''.join(cylinders)}</world></sdf>"
    (folder / "world_files" / f"world_{number}.world").write_text(text)
    np.save(folder / "path_files" / f"path_{number}.npy", CELLS)


def test_the_cylinders_and_the_path_of_a_world(tmp_path):
    write_world(tmp_path)

    [world] = read_barn(tmp_path)

    assert world.number == 3
    assert world.cylinders.tolist() == [[x, y, 0.075] for x, y in PLACES]
    # The cells' middles are x = 14 * 0.15 - 4.575 and y = 5.075 to 9.275.
    assert world.shortest_path == pytest.approx(
        np.hypot(0.225, 2.075) + 4.2 + np.hypot(0.225, 3.725)
    )


def test_world_files_without_a_path_file_are_ignored(tmp_path):
    """A clone of the challenge has DynaBARN's, too, which are not well-formed."""
    for name in ("a", "b", "barn", "c", "d"):
        (tmp_path / name).mkdir()
        write_world(tmp_path / name)
        if name != "barn":
            (tmp_path / name / "world_files" / "world_3.world").write_text("<sdf>")
            (tmp_path / name / "path_files" / "path_3.npy").unlink()

    [world] = read_barn(tmp_path)

    assert len(world.cylinders) == len(PLACES)


def test_the_command_writes_a_sweep_with_the_rules_of_barn(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_world(tmp_path, 0)
    write_world(tmp_path, 12)

    assert main(["worlds", "--import-barn", ".", "--out", "ours"]) == 0

    settings = read_scenario_file(tmp_path / "ours" / "scenarios.yaml")
    assert "2 worlds; flatland sweep ours/scenarios.yaml" in capsys.readouterr().out
    assert [each.name for each in settings.worlds] == ["world_0", "world_12"]
    with Simulation(tmp_path / "ours" / "world_12.yaml") as simulation:
        assert simulation.models["robot"].pose == pytest.approx(START, abs=1e-6)
        [body] = simulation.world.models["cylinders"].bodies.values()
        assert [each.shape.center for each in body.config.footprints] == PLACES
        assert {each.shape.radius for each in body.config.footprints} == {0.075}
    assert {each.group for each in settings.worlds} == {"BARN"}
    task = settings.worlds[0].task
    assert (task.goal, task.goal_radius, settings.time_limit) == (GOAL, 1.0, 100.0)


@pytest.mark.parametrize("controller", ["gaps", "planner"])
def test_a_robot_drives_past_the_cylinders(tmp_path, controller):
    write_world(tmp_path, places=[(-2.25, 6.0), *PLACES])
    write_barn(read_barn(tmp_path), tmp_path)
    settings = read_scenario_file(tmp_path / "scenarios.yaml")
    [scenario] = [each for each in scenarios_of(settings) if each.controller.name == controller]
    runner = ScenarioRunner(settings)

    result = runner.run(scenario)

    assert result.error == ""
    assert result.row["success"]
    best = result.row["shortest_path"] / 2.0
    assert result.row["barn_score"] == pytest.approx(
        best / np.clip(result.row["time"], 2 * best, 8 * best)
    )


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("world_files/world_3.world", "<sdf>", "world_3.world: expected a world of BARN"),
        ("world_files/world_3.world", "<sdf></sdf>", "expected cylinders, found none"),
        ("path_files/path_3.npy", "no numpy", "path_3.npy: expected columns and rows"),
        ("path_files/path_3.npy", None, "found no path_3.npy"),
        ("world_files/world_3.world", None, "expected worlds of BARN"),
    ],
)
def test_files_that_are_wrong_are_named(tmp_path, name, content, problem):
    write_world(tmp_path)
    (tmp_path / name).unlink()
    if content is not None:
        (tmp_path / name).write_text(content)

    with pytest.raises(FlatlandError, match=problem):
        read_barn(tmp_path)


@pytest.mark.parametrize("radius", ["-1", "0", "1e308", "nan", "inf"])
def test_a_cylinder_of_an_impossible_radius_is_refused(tmp_path, radius):
    write_world(tmp_path)
    path = tmp_path / "world_files" / "world_3.world"
    path.write_text(path.read_text().replace("0.075000", radius, 1))

    with pytest.raises(FlatlandError, match=r"world_3\.world: expected cylinders of 0\.001 m"):
        read_barn(tmp_path)


def with_a_header_of_gigabytes(path):
    content = path.read_bytes()
    path.write_bytes(content.replace(b"(2, 2), }" + b" " * 9, b"(2" + b"0" * 9 + b", 2), }"))
    assert path.stat().st_size == len(content)


@pytest.mark.parametrize(
    "spoil",
    [
        *(
            lambda path, cells=cells: np.save(path, cells)
            for cells in ([[math.nan, 0.0]], [[1e300, 0.0]], [[1j, 0]], ["a"])
        ),
        with_a_header_of_gigabytes,
    ],
)
def test_a_path_of_impossible_cells_is_refused(tmp_path, spoil):
    write_world(tmp_path)
    spoil(tmp_path / "path_files" / "path_3.npy")

    with pytest.raises(FlatlandError, match=r"path_3\.npy: expected columns and rows"):
        read_barn(tmp_path)


@pytest.mark.parametrize("name", ["scenarios.yaml", "robot.model.yaml", "world_3.yaml"])
def test_a_file_of_another_content_is_not_replaced(tmp_path, name):
    write_world(tmp_path)
    worlds = read_barn(tmp_path)
    write_barn(worlds, tmp_path)
    write_barn(worlds, tmp_path)  # the same again
    (tmp_path / name).write_text("# mine\n")
    (tmp_path / "world_3.model.yaml").unlink()

    with pytest.raises(FlatlandError, match=f"{name}: expected a new file, found one with other"):
        write_barn(worlds, tmp_path)

    assert (tmp_path / name).read_text() == "# mine\n"
    assert not (tmp_path / "world_3.model.yaml").exists()
