"""The gate of `flatland sweep --baseline` in trials: it stops worse controllers, not equal ones."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Callable, Dict

import numpy as np

from flatland2d.sweep import SweepRun, drivers
from flatland2d.sweep.orca import orca
from flatland_benchmark.case import Figures, case


def drive_to_goal(run: SweepRun, speed: float) -> None:
    """Turns to the goal, and drives."""
    while run.is_running:
        run.robot.command(speed if abs(run.bearing) < 0.5 else 0.0, 2.0 * run.bearing)
        run.step()


_CONTROLLERS: Dict[str, Callable[..., None]] = {
    "straight": drive_to_goal,
    "gaps": drivers.gaps,
    "orca": orca,
}
_SPEED = 0.5
_SLOWER = 0.45
_SEEDS = 100


def drive(run: SweepRun, controller: str, chance: int, speed: float) -> None:
    """Turns by chance for up to a second, then drives."""
    rng = np.random.default_rng([chance, run.seed])
    for _ in range(int(rng.integers(1, 11))):
        run.robot.command(0.0, float(rng.normal()))
        run.step()
    if run.is_running:
        _CONTROLLERS[controller](run, speed=speed)


@case("gate", "flatland sweep --baseline, of equal controllers and of a slower one")
def try_gate(worlds: Path) -> Figures:
    """Three sweeps of the same tasks, which are drawn anew in each run of the case.

    Each sweep has turns of its own, so no two are equal. A figure is 1 if the sweep was stopped.
    """
    usual = dict.fromkeys(_CONTROLLERS, _SPEED)
    first = int(np.random.default_rng().integers(1_000_000)) * _SEEDS
    with tempfile.TemporaryDirectory() as folder:
        baseline = Path(folder, "baseline")
        slower = {**usual, "gaps": _SLOWER}
        _sweep(baseline, first, usual)
        against = ["--baseline", str(baseline)]
        return {
            "equal ones stopped": _sweep(Path(folder, "equal"), first, usual, *against),
            "a slower one stopped": _sweep(Path(folder, "slower"), first, slower, *against),
        }


def _sweep(out: Path, first: int, speeds: Dict[str, float], *arguments: str) -> float:
    """Sweeps controllers of these speeds [m/s] over the seeds from `first`; returns the exit code.

    Raises:
        RuntimeError: it has failed.
    """
    chance = int(np.random.default_rng().integers(1_000_000))
    controllers = [
        {
            "name": name,
            "call": f"{__name__}:drive",
            "arguments": {"controller": name, "chance": chance, "speed": speed},
        }
        for name, speed in speeds.items()
    ]
    content = {
        "worlds": [f"package://flatland_gym/worlds/{name}.yaml" for name in ("discs", "doors")],
        "controllers": controllers,
        "seeds": {"first": first, "count": _SEEDS},
        "goal_distance": [3, 8],
        "time_limit": 40,
        "step_size": 0.05,
        "control_period": 0.1,
        "start": "random",
        "goal": "random",
    }
    file = out.with_suffix(".yaml")
    file.write_text(json.dumps(content))
    command = [sys.executable, "-m", "flatland2d", "sweep", str(file), "--out", str(out)]
    command += ["--no-progress", "--pictures", "0", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    written = out / ("regressions.xml" if arguments else "results.csv")
    if "failed to run" in done.stderr or not written.exists():
        raise RuntimeError(done.stdout + done.stderr)
    return float(done.returncode)
