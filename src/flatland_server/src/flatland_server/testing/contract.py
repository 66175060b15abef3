"""The contract that all plugins keep."""

import contextlib
from typing import Any, Callable, Collection, Iterator, Mapping, Optional, Tuple, Union

import yaml

from flatland_server.exceptions import FlatlandError
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.testing import behaviour_checks, configuration_checks, name_checks
from flatland_server.testing.checked_plugin import CheckedPlugin
from flatland_server.testing.files import Entry

CHECKS: Tuple[Callable[[CheckedPlugin], Iterator[str]], ...] = (
    configuration_checks.check_keys,
    configuration_checks.check_unknown_keys,
    configuration_checks.check_missing_keys,
    configuration_checks.check_wrong_values,
    behaviour_checks.check_without_subscribers,
    name_checks.check_names,
    behaviour_checks.check_rates,
    behaviour_checks.check_messages,
    behaviour_checks.check_states,
    behaviour_checks.check_drawing,
    behaviour_checks.check_readings,
    behaviour_checks.check_bad_messages,
    behaviour_checks.check_end,
)
"""The checks of `check_plugin`, in their order. Each yields the problems that it finds."""

_MOST_SHOWN = 20


class PluginContractError(AssertionError):
    """A plugin does not keep the contract; the message lists what was expected and found."""


def check_plugin(
    entry: Entry,
    *,
    other_keys: Collection[str] = (),
    model: Optional[Entry] = None,
    world: Optional[Entry] = None,
    files: Mapping[str, str] = {},
    loader: Optional[PluginLoader] = None,
) -> None:
    """Checks that a plugin keeps the contract of plugins.

    - It reads the keys of `entry` and no others.
    - A misspelt key, at any depth, is refused with file, line and a suggestion; so is a value of a
      wrong type, NaN, a rate of zero, and the name of a body or joint that the model does not have.
    - Without subscribers it makes and publishes no message and no transform; and what it publishes
      later does not depend on when the subscriber came.
    - The model's namespace is put before its topics and frames exactly once; topics that begin with
      "/" stay outside of it, and so do the frames of `odom_frame_id`, `ground_truth_frame_id` and
      `world_frame_id`, unless they begin with "~". Topics and frames have the names in the entry.
    - With an `update_rate` or `pub_rate` it publishes at that rate of simulated time.
    - Equal seeds give equal messages, poses and walls; a `MessageWriter` makes the bytes of its
      message.
    - A run goes on with the same messages from a state that was saved and loaded in a new world; a
      reset world runs as it did first.
    - Pictures of the world change nothing in the run.
    - Two readings by a program (`ModelPlugin.read`) at one time are equal, also without
      subscribers; they change nothing in the run.
    - An empty message, or one of NaN or infinities, does not make it fail.
    - Its end leaves no topic, subscription, transform, body or joint behind, and nothing refers to
      the plugin any more. A deleted model can be spawned again.

    The plugin is loaded some hundred times and simulated for a few seconds, which takes about a
    second.

    Args:
        entry: of the plugin in a model or world file, with its type, its name and all its keys.
        other_keys: names of keys that it reads too, such as deprecated ones.
        model: the file of the robot, without plugins; by default a disc called "base".
        world: the world's file, without the robot, which is called "robot" and stands at the
            origin; by default a room of 10 x 10 m, with its walls on the layer "map".
        files: other files that these name, by their names.
        loader: finds the plugin; by default among those that packages export. For a class that no
            package exports: `PluginLoader([PluginDeclaration.of(MyPlugin)])`.

    Raises:
        PluginContractError: an AssertionError that lists what was expected and what was found.
    """
    case = CheckedPlugin(
        _document(entry),
        _document(model) if model is not None else None,
        _document(world) if world is not None else None,
        files,
        loader,
        other_keys,
    )
    label = str(case.entry["type"])
    try:
        case.load().simulation.world.close()
    except FlatlandError as error:
        raise PluginContractError(f"{label} is refused as it is given:\n{error}") from error
    with contextlib.closing(case):
        problems = [problem for check in CHECKS for problem in check(case)]
    if problems:
        shown = "\n- ".join(problems[:_MOST_SHOWN])
        more = f"\nand {len(problems) - _MOST_SHOWN} more" if len(problems) > _MOST_SHOWN else ""
        raise PluginContractError(f"{label} does not keep the contract:\n- {shown}{more}")


def _document(entry: Union[str, Mapping[str, Any]]) -> Mapping[str, Any]:
    if not isinstance(entry, str):
        return entry
    try:
        document = yaml.safe_load(entry)
    except yaml.YAMLError:
        document = None
    if not isinstance(document, dict):
        document = yaml.safe_load(f"{{{entry}}}")
    return dict(document)
