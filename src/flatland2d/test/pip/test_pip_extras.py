"""Extras of the library as pip installs them, of hundreds of megabytes: Ray, Stable-Baselines3."""

import os
import re
import tempfile

import pip_environments
import pytest
from pip_environments import ROOT

pytestmark = pytest.mark.slow


def installed(make, name):
    """The environment that a function makes; skips where it cannot be installed."""
    try:
        return make()
    except pytest.fail.Exception as error:
        pytest.skip(f"{name} cannot be installed: {error}")


SWEEP = """
worlds: [{name: discs, world: "package://flatland_gym/worlds/discs.yaml"}]
controllers:
  - {name: trained, policy: "package://flatland_gym/policies/discs.npz"}
  - {name: direct, call: "direct.py:drive"}
parameters: {/disc_radius: [0.2, 0.35]}
seeds: 4
start: random
goal: random
goal_distance: [2, 5]
time_limit: 15
"""
DIRECT = """
import os, signal

def drive(run):
    mark = os.path.join(os.path.dirname(__file__), "mark")
    if run.seed == 1 and not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    while run.is_running:
        run.robot.command(0.6, 2.0 * run.bearing)
        run.step()
    return {"turns": 3, "is_near": run.distance < 1, "yaw": run.robot.pose.yaw}
"""
READ_SCHEMA = """
import sys, pyarrow.parquet
table = pyarrow.parquet.read_table(sys.argv[1])
print(table.num_rows, *(f"{field.name}:{field.type}" for field in table.schema))
"""


def test_a_sweep_is_the_same_to_the_bit_in_processes_and_on_ray(tmp_path):
    """With a worker that is killed in its first attempt."""
    library = installed(pip_environments.with_ray, "Ray")
    (tmp_path / "scenarios.yaml").write_text(SWEEP)
    (tmp_path / "direct.py").write_text(DIRECT)
    folders = {}
    for arguments in (["--jobs", "1"], ["--jobs", "2"], ["--jobs", "2", "--ray", "local"]):
        folder = folders[arguments[-1]] = tmp_path / f"out_{arguments[-1]}"
        (tmp_path / "mark").unlink(missing_ok=True)
        # Ray's sockets need a short name.
        with tempfile.TemporaryDirectory(prefix="ray_") as ray_folder:
            words = ["sweep", tmp_path / "scenarios.yaml", "--out", folder, *arguments]
            output = library.command("flatland", *words, RAY_TMPDIR=ray_folder)
        assert "its worker was killed by SIGKILL; it is run again" in output

    for name in ("results.parquet", "results.csv", "summary.csv", "report.html"):
        contents = {folder.joinpath(name).read_bytes() for folder in folders.values()}
        assert len(contents) == 1, name
    count, *fields = library.run("-c", READ_SCHEMA, folders["local"] / "results.parquet").split()
    assert count == "16"
    expected = (
        "scenario:int64 world:string /disc_radius:double seed:int64 success:bool "
        "path_length:double is_near:bool turns:int64 yaw:double"
    )
    assert set(expected.split()) <= set(fields)


def test_stable_baselines3_is_an_extra_that_learns(tmp_path):
    library = installed(pip_environments.with_sb3, "Stable-Baselines3")
    tests = ROOT / "src" / "flatland_gym" / "test" / "test_sb3.py"
    options = ("-q", "-x", "--noconftest", "-c", os.devnull, "-p", "no:cacheprovider")

    variables = {"OMP_NUM_THREADS": 1, "SB3_LOGDIR": tmp_path}
    output = library.run("-m", "pytest", *options, tests, **variables)

    assert re.search(r"^\d+ passed", output, re.MULTILINE), output
