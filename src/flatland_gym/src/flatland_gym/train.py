"""Trains a policy: `python3 -m flatland_gym.train --world discs policy.npz`."""

import argparse
import importlib.util
import math
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Tuple

import numpy as np
import yaml

from flatland2d import FlatlandError, MissingPackageError
from flatland2d.sweep.intervals import rate
from flatland_gym.policy import Policy

if TYPE_CHECKING:
    from flatland_gym.evaluation import Evaluation
    from flatland_gym.training_progress import Progress

# Modules that need Gymnasium are imported where they are used: `main` reports its absence.

_BLAS_THREADS = "OPENBLAS_NUM_THREADS"
_INTERRUPTED = 130
"""Exit code after Ctrl-C."""
_FIRST_UNSEEN = 1_000_000
"""Seeds of evaluations begin here; those of training are below."""


def main(arguments: Optional[List[str]] = None) -> int:
    """Trains, evaluates and saves a policy; returns an exit code."""
    options = _parser().parse_args(arguments)
    if importlib.util.find_spec("gymnasium") is None:
        print("error: training needs Gymnasium: pip install 'flatland2d[gym]'", file=sys.stderr)
        return 1
    try:
        return _train(options)
    except (FlatlandError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


def _train(options: argparse.Namespace) -> int:
    from flatland_gym.evaluation import StraightDriver, evaluate
    from flatland_gym.training_progress import TrainingInterrupted

    _require_place(options.policy)  # before the training, not after it
    if options.curve is not None:
        _require_place(options.curve)
        _require_format(options.curve)
    settings: Dict[str, Any] = {
        "world": options.world,
        "frame_skip": 2,
        "obstacles": options.obstacles,
        "time_limit": 30.0,
        **dict(options.set),
    }
    progress: List[Progress] = []
    has_bar = _has_bar()

    def report(now: "Progress") -> None:
        progress.append(now)
        if len(progress) % 20 == 0 and not has_bar:
            recent = progress[-20:]
            success = _mean_success(recent)
            rate = now.steps / now.seconds
            print(
                f"{now.steps:>9} steps  {now.seconds:6.0f} s  {rate:6.0f} steps/s  "
                f"success {100 * success:5.1f} %",
                flush=True,
            )

    learn = _learn_by_sb3 if options.library == "sb3" else _learn
    is_interrupted, begin = False, time.process_time()
    try:
        policy = learn(options, settings, report)
    except TrainingInterrupted as interruption:
        policy, is_interrupted = interruption.policy, True
    policy.save(options.policy)
    if options.curve is not None:
        save_curve(progress, options.curve)
    if is_interrupted:
        done = progress[-1].steps if progress else 0
        print(f"{options.policy}: interrupted after {done} steps", file=sys.stderr)
        return _INTERRUPTED
    steps, used = progress[-1].steps, time.process_time() - begin
    print(f"trained: {steps} steps, {used:.0f} s of processor time")
    seeds = range(_FIRST_UNSEEN, _FIRST_UNSEEN + options.episodes)
    result = evaluate(policy, seeds, options.threads, **settings)
    print(f"{options.policy}: {_rates(result)}, of {options.episodes} episodes with new seeds")
    straight = StraightDriver(policy.beams, len(policy.action_limits))
    print(f"straight at the goal: {_rates(evaluate(straight, seeds, options.threads, **settings))}")
    return 0


def _rates(result: "Evaluation") -> str:
    """The rates of an evaluation, with intervals of 95 % confidence."""
    parts = []
    for name, found in (("success", result.success), ("collisions", result.collision)):
        part, low, high = (100.0 * value for value in rate(int(found.sum()), len(found)))
        parts.append(f"{name} {part:.1f} % ({low:.1f} to {high:.1f})")
    return ", ".join(parts)


def _learn(
    options: argparse.Namespace, settings: Dict[str, Any], report: Callable[["Progress"], None]
) -> Policy:
    """Trains by `Ppo`."""
    from flatland_gym.navigation_vector_env import NavigationVectorEnv
    from flatland_gym.ppo import Ppo
    from flatland_gym.ppo_settings import PpoSettings

    ppo = PpoSettings.of(dict(options.learner))
    env = NavigationVectorEnv(options.envs, options.threads, autoreset_mode="SameStep", **settings)
    try:
        learner = Ppo(env, ppo, options.seed)
        return learner.train(options.steps, 60.0 * options.minutes, report, _has_bar())
    finally:
        env.close()


def _has_bar() -> bool:
    """True if a bar of tqdm takes the place of lines."""
    return sys.stderr.isatty() and importlib.util.find_spec("tqdm") is not None


def _learn_by_sb3(
    options: argparse.Namespace, settings: Dict[str, Any], report: Callable[["Progress"], None]
) -> Policy:
    """Trains by the PPO of Stable-Baselines3."""
    from flatland_gym.sb3 import NavigationVecEnv
    from flatland_gym.sb3_training import train

    if options.learner:
        raise FlatlandError(
            "--learner is for --library numpy: Stable-Baselines3 has its own settings"
        )
    env = NavigationVecEnv(options.envs, threads=options.threads, **settings)
    return train(env, options.seed, options.steps, 60.0 * options.minutes, report, _has_bar())


def save_curve(progress: List["Progress"], path: Path) -> None:
    """Draws the rate of success over the steps into a file.

    Raises:
        FlatlandError: matplotlib is not installed.
    """
    figure = _figure()
    axes = figure.add_subplot(xlabel="steps", ylabel="success [%]", ylim=(0, 100))
    window = 10
    success = [
        100 * _mean_success(progress[max(0, end - window) : end])
        for end in range(1, len(progress) + 1)
    ]
    axes.plot([each.steps for each in progress], success)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=120)


def _mean_success(progress: List["Progress"]) -> float:
    """The mean of the rates of success; NaN if no episode has ended."""
    found = [each.success for each in progress if each.episodes]
    return float(np.mean(found)) if found else math.nan


def _require_place(path: Path) -> None:
    """Raises a FlatlandError if a file cannot be written there."""
    folder = path.parent
    if path.is_dir():
        raise FlatlandError(f"{path} cannot be written: it is a folder")
    if not folder.is_dir():
        raise FlatlandError(f"{path} cannot be written: there is no folder {folder}")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise FlatlandError(f"{path} cannot be written: permission denied")


def _require_format(path: Path) -> None:
    """Raises a FlatlandError if Matplotlib is not installed, or has no format of this name."""
    known = _figure().canvas.get_supported_filetypes()
    if path.suffix and path.suffix[1:].lower() not in known:
        names = ", ".join(f".{name}" for name in sorted(known))
        raise FlatlandError(f"{path}: expected a name that ends with one of {names}")


def _figure() -> Any:
    """An empty figure of matplotlib."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingPackageError(
            "a curve needs matplotlib: pip install 'flatland2d[view]'"
        ) from None
    figure = Figure(figsize=(7, 4), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _whole(minimum: int) -> Callable[[str], int]:
    """The type of an argument that is a whole number of a minimum or more."""

    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < minimum:
            raise argparse.ArgumentTypeError(
                f'expected a whole number of {minimum} or more, found "{text}"'
            )
        return int(text)

    return read


def _minutes(text: str) -> float:
    """A number above 0, which may be infinite."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f'expected a number above 0, found "{text}"')
    return value


def _setting(text: str) -> Tuple[str, Any]:
    """The name and the value of an argument of the environment."""
    name, separator, value = text.partition("=")
    try:
        found = yaml.safe_load(value)
    except yaml.YAMLError:
        separator = ""
    if not (name and separator):
        raise argparse.ArgumentTypeError(
            f'expected NAME=VALUE with a value in YAML, found "{text}"'
        )
    return name, found


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python3 -m flatland_gym.train", description="Trains a policy by PPO."
    )
    add = parser.add_argument
    add("policy", type=Path, help="the file to write: .npz")
    add("--world", default="discs", help="a scenario, a shipped world or a file (default: discs)")
    add("--obstacles", type=_whole(0), default=0, help="columns to add to it (default: 0)")
    add("--minutes", type=_minutes, default=4.0, help="to train at most (default: 4)")
    add(
        "--steps",
        type=_whole(1),
        default=10**9,
        help="to train at most, of all environments together",
    )
    add("--seed", type=_whole(0), default=1, help="of all random numbers (default: 1)")
    add("--envs", type=_whole(1), default=128, help="environments at a time (default: 128)")
    add("--threads", type=_whole(1), default=2, help="that step them (default: 2)")
    add("--episodes", type=_whole(1), default=200, help="of the evaluation (default: 200)")
    add(
        "--set",
        type=_setting,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="another argument of the environment, in YAML: --set lidar=front --set beams=32",
    )
    add(
        "--learner",
        type=_setting,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting of the learner, as of PpoSettings: --learner discount=0.995",
    )
    add("--library", choices=("numpy", "sb3"), default="numpy", help="what learns (default: numpy)")
    add("--curve", type=Path, help="draw the success over the steps into this file")
    return parser


def _limit_blas_threads() -> None:
    """Starts this program again with one thread for NumPy's products, unless the user has chosen.

    The products are small, and threads that wait for each other are slow on a busy machine: five
    times as slow with twice as many running processes as cores. OpenBLAS reads the variable when
    NumPy loads it.
    """
    if _BLAS_THREADS not in os.environ:
        os.environ[_BLAS_THREADS] = "1"
        os.execv(sys.executable, [sys.executable, "-m", "flatland_gym.train", *sys.argv[1:]])


if __name__ == "__main__":
    _limit_blas_threads()
    sys.exit(main())
