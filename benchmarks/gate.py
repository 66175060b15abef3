"""`flatland sweep --baseline` in trials: how often it stops worse controllers, and equal ones.

    usage: gate.py [--trials 20] [--seeds 100] [--slower 0.1] [--jobs N]

Each trial has tasks of its own: three controllers, two scenes, so many seeds. The same sweep is run
three times. Each run begins with a turn that is drawn anew, so that no two sweeps are equal. The
second sweep has the same controllers as the first, the baseline; in the third one a controller is
slower. Prints how many of the sweeps ended with exit code 1.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Dict

import numpy as np
import yaml

from flatland2d.sweep import SweepRun, drivers
from flatland2d.sweep.orca import orca

CONTROLLERS = {"gaps": drivers.gaps, "orca": orca}
SCENES = ("discs", "doors")


def straight(run: SweepRun, speed: float) -> None:
    """Turns to the goal, and drives."""
    while run.is_running:
        run.robot.command(speed if abs(run.bearing) < 0.5 else 0.0, 2.0 * run.bearing)
        run.step()


def drive(run: SweepRun, controller: str, chance: int, speed: float) -> None:
    """Turns by chance for up to a second, then drives."""
    rng = np.random.default_rng([chance, run.seed])
    for _ in range(int(rng.integers(1, 11))):
        run.robot.command(0.0, float(rng.normal()))
        run.step()
    if run.is_running:
        {**CONTROLLERS, "straight": straight}[controller](run, speed=speed)


def sweep(trial: int, chance: int, speeds: Dict[str, float], seeds: int) -> Dict[str, Any]:
    """The content of a scenario file."""
    return {
        "worlds": [f"package://flatland_gym/worlds/{scene}.yaml" for scene in SCENES],
        "controllers": [
            {
                "name": name,
                "call": "gate:drive",
                "arguments": {"controller": name, "chance": chance, "speed": speed},
            }
            for name, speed in speeds.items()
        ],
        "seeds": {"first": trial * seeds, "count": seeds},
        "start": "random",
        "goal": "random",
        "goal_distance": [3, 8],
        "time_limit": 40,
        "step_size": 0.05,
        "control_period": 0.1,
    }


def is_worse(folder: Path, name: str, content: Dict[str, Any], options: argparse.Namespace) -> bool:
    """Runs a sweep; true if it is worse than that of the name "baseline"."""
    file = folder / f"{name}.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False))
    command = [sys.executable, "-m", "flatland2d", "sweep", file, "--out", folder / name]
    command += ["--no-progress", "--pictures", "0", "--jobs", options.jobs]
    if name != "baseline":
        command += ["--baseline", folder / "baseline"]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1) or "failed to run" in done.stderr:
        raise RuntimeError(done.stdout + done.stderr)
    written = "results.csv" if name == "baseline" else "regressions.xml"
    if not (folder / name / written).exists():
        raise RuntimeError(done.stdout + done.stderr)
    return done.returncode == 1


def main() -> None:
    """Prints the counts after each trial."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--slower", type=float, default=0.1, help="part of the speed")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    usual = {"straight": 0.5, "gaps": 0.5, "orca": 0.5}
    slower = {**usual, "gaps": 0.5 * (1.0 - options.slower)}
    same = caught = 0
    for trial in range(options.trials):
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            (place / "gate.py").write_text(Path(__file__).read_text(encoding="utf-8"))
            for number, (name, speeds) in enumerate(
                (("baseline", usual), ("same", usual), ("slower", slower))
            ):
                content = sweep(trial, 3 * trial + number, speeds, options.seeds)
                worse = is_worse(place, name, content, options)
                same += worse and name == "same"
                caught += worse and name == "slower"
        print(f"of {trial + 1} trials: {same} stopped with the same, {caught} with a slower one")


if __name__ == "__main__":
    main()
