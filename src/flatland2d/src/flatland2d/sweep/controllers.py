"""Finds the functions that drive robots.

A controller is a function of a `SweepRun`, and of its arguments in the scenario file:

    def straight(run, speed=0.5):
        while run.is_running:
            run.robot.command(speed, 0.0)
            run.step()
"""

import importlib
import importlib.util
import inspect
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional

from flatland2d.sweep.parameters import controller_arguments
from flatland2d.sweep.settings import Controller
from flatland_server.config import to_path
from flatland_server.exceptions import FlatlandError, UsageError, suggestion

POLICY_DRIVER = "flatland_gym.sweep_policy:drive"
"""The function that drives by a policy: found by its name, as plugins are."""

ControllerFunction = Callable[..., Any]

_NOT_CALLED = (inspect.isgeneratorfunction, inspect.iscoroutinefunction, inspect.isasyncgenfunction)
"""Tests for generators and coroutines: functions that do nothing when they are only called."""


def python_file(target: str, folder: Path) -> Optional[Path]:
    """The file of a function that is named as "file.py:function"; None for one of a module."""
    module = target.rpartition(":")[0]
    return folder / module if module.endswith(".py") else None


def policy_file(controller: Controller, folder: Path) -> Path:
    """The file of a controller's policy.

    Args:
        controller: an entry of a scenario file with a policy.
        folder: the scenario file's folder.

    Raises:
        FlatlandError: it is a `package://` name of a package that is not there.
    """
    return folder / to_path(controller.policy)


def find_controller(controller: Controller, folder: Path) -> ControllerFunction:
    """The function of a controller.

    Args:
        controller: an entry of a scenario file.
        folder: of the scenario file; modules are looked up there first.

    Raises:
        FlatlandError: there is no such function, or its file cannot be imported.
    """
    if not controller.target:
        return _run_the_world
    module_name, _, name = controller.target.rpartition(":")
    file = python_file(controller.target, folder)
    what = f'the controller "{controller.name}"'
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    try:
        module = _module_of(file) if file else importlib.import_module(module_name)
    except (Exception, SystemExit) as error:
        reason = f"{type(error).__name__}: {error}"
        raise FlatlandError(f"{what}: {module_name} cannot be imported: {reason}") from error
    function = getattr(module, name, None)
    if not callable(function):
        known = [each for each, value in vars(module).items() if inspect.isfunction(value)]
        hint = suggestion(name, known)
        raise FlatlandError(f'{what}: {module_name} has no function "{name}"{hint}')
    if any(test(function) for test in _NOT_CALLED):
        raise FlatlandError(
            f"{what}: expected {name} to be a function that steps the run until it is over, found "
            "a generator or a coroutine"
        )
    found: ControllerFunction = function
    return found


def arguments_of(
    controller: Controller,
    function: ControllerFunction,
    parameters: Mapping[str, Any],
    folder: Path,
) -> Dict[str, Any]:
    """The keyword arguments of a controller's function.

    Raises:
        UsageError: the function does not take them.
    """
    arguments = {**controller.arguments, **controller_arguments(parameters)}
    if controller.policy:
        arguments["file"] = str(policy_file(controller, folder))
    try:
        inspect.signature(function).bind(None, **arguments)
    except TypeError as error:
        raise UsageError(f'the controller "{controller.name}": {error}') from None
    return arguments


@lru_cache(maxsize=None)
def _module_of(file: Path) -> Any:
    """The module of a file, imported once."""
    name = f"flatland_controller_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise FlatlandError(f"{file} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and pickle look there
    spec.loader.exec_module(module)
    return module


def _run_the_world(run: Any, **_: Any) -> None:
    """No controller: the world runs by itself."""
    while run.is_running:
        run.step()
