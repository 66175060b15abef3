"""Visible walls of batches are kept in files, which change nothing but the speed."""

import gc
import math
import os

import numpy as np
import pytest

from flatland2d import SimulationBatch
from flatland2d.batch import wall_cache
from flatland_server import _core

ENVIRONMENTS = 64
ROUNDS = 400  # as many scans at each place, until its walls are searched for and found


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The folder of the files."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache/flatland2d/visible_walls"


@pytest.fixture
def world(tmp_path):
    """Four connected rooms with pillars, and a robot; different walls in each test."""
    shift = np.random.default_rng().uniform(0.0, 0.2)
    lines = ["0 0 12 0", "12 0 12 12", "12 12 0 12", "0 12 0 0"]
    lines += ["0 3 11 3", "1 6 12 6", "0 9 11 9"]
    for x in range(1, 11):
        for y in (1.0 + shift, 4.2, 7.2, 10.2):
            corners = [(x, y), (x + 0.5, y), (x + 0.5, y + 0.4), (x, y + 0.4)]
            lines += [f"{a} {b} {c} {d}" for (a, b), (c, d) in zip(corners, corners[1:])]
            lines += [f"{x} {y + 0.4} {x} {y}"]
    (tmp_path / "hall.dat").write_text("\n".join(lines))
    (tmp_path / "hall.yaml").write_text(
        "{type: line_segments, data: hall.dat, scale: 1, origin: [0, 0, 0]}"
    )
    laser = {
        "type": "Laser",
        "name": "laser",
        "body": "base",
        "range": 20,
        "angle": {"min": -math.pi, "max": math.pi - 0.05, "increment": 0.05},
    }
    drive = {"type": "DiffDrive", "name": "drive", "body": "base"}
    footprint = {"type": "circle", "radius": 0.1, "density": 1}
    robot = {"bodies": [{"name": "base", "footprints": [footprint]}], "plugins": [drive, laser]}
    return {
        "properties": {},
        "layers": [{"name": "map", "map": str(tmp_path / "hall.yaml")}],
        "models": [{"name": "robot", "pose": [2, 2, 0], "model": robot}],
    }


def scans(world, rounds=1):
    """Scans from all over the world, by a new batch: the last of several from each place."""
    with SimulationBatch(world, ENVIRONMENTS) as batch:
        poses = batch.free_poses(ENVIRONMENTS, 0.15, np.random.default_rng(1))
        for _ in range(rounds):
            ranges = batch.reset(poses=poses).ranges
        return ranges.copy()


def test_scans_are_the_same_without_files_with_new_ones_and_with_those_of_before(world, folder):
    few = scans(world)
    assert not folder.exists()  # few scans search nothing
    many = scans(world, ROUNDS)
    (file,) = folder.iterdir()
    content = file.read_bytes()
    assert len(content) > 5_000
    assert np.array_equal(many, few)

    assert np.array_equal(scans(world), few)
    assert file.read_bytes() == content  # not written again


def test_a_batch_that_is_not_closed_writes_what_it_has_found(world, folder):
    batch = SimulationBatch(world, ENVIRONMENTS)
    poses = batch.free_poses(ENVIRONMENTS, 0.15, np.random.default_rng(1))
    for _ in range(ROUNDS):
        batch.reset(poses=poses)

    del batch
    gc.collect()

    assert len(list(folder.iterdir())) == 1


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: content[:-4],
        lambda content: b"",
        lambda content: b"something else" * 100,
        lambda content: content[:5000] + bytes([content[5000] ^ 1]) + content[5001:],
    ],
    ids=["shorter", "empty", "foreign", "one bit"],
)
def test_a_damaged_file_is_ignored_and_replaced(world, folder, damage):
    expected = scans(world, ROUNDS)
    (file,) = folder.iterdir()
    content = file.read_bytes()
    file.write_bytes(damage(content))
    gc.collect()  # while a process has the walls, it reads their file once
    assert np.array_equal(scans(world, ROUNDS), expected)
    assert len(file.read_bytes()) >= len(content)


def test_a_pipe_is_ignored_and_replaced(world, folder):
    expected = scans(world, ROUNDS)
    (file,) = folder.iterdir()
    file.unlink()
    os.mkfifo(file)
    gc.collect()

    assert np.array_equal(scans(world, ROUNDS), expected)
    assert file.is_file()


def test_a_folder_that_cannot_be_written_to_is_ignored(world, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert np.isfinite(scans(world, ROUNDS)).any()


def test_the_oldest_files_are_deleted_beyond_the_limit(world, folder, monkeypatch):
    folder.mkdir(parents=True)
    old = folder / "old"
    old.write_bytes(bytes(1_000_000))
    os.utime(old, (0, 0))
    monkeypatch.setattr(wall_cache, "_MOST_BYTES", 900_000)
    scans(world, ROUNDS)
    assert not old.exists()
    assert len(list(folder.iterdir())) == 1


def test_batches_of_a_process_read_a_file_once(world, folder):
    scans(world, ROUNDS)
    (file,) = folder.iterdir()
    gc.collect()
    with SimulationBatch(world, 1):
        file.write_bytes(b"")
        scans(world)
    assert file.read_bytes() == b""  # neither read nor written


def test_numbers_that_are_no_walls_are_refused():
    walls = _core.VisibleWalls(np.random.default_rng().uniform(0, 9, (100, 4)))
    nothing = walls.known()
    assert not walls.take(b"abc")
    assert not walls.take(nothing + nothing)
    assert walls.take(nothing)
