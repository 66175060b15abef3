"""The parameters of the node flatland_server."""

import math
import re
from pathlib import Path
from typing import Any, NamedTuple, Optional, Tuple

import rospy

from flatland_server.config.file_names import to_path
from flatland_server.exceptions import FlatlandError
from flatland_server.maps.simplify_outlines import TOLERANCES


class ServerConfig(NamedTuple):
    """The node's parameters: its private ones, or those of a namespace above, or global ones."""

    world_path: Path
    update_rate: float
    step_size: float
    control_period: Optional[float]
    """Simulated time of a call of /step_world [s]; None is the default of `StateServices`."""
    train_mode: bool
    show_viz: bool
    viz_pub_rate: float
    seed: int
    simplify_map: int
    no_return: str
    static_tf: bool
    tf_by_namespace: bool
    wall_clock_stamps: bool
    realtime_priority: bool
    rospy_patches: bool
    map_to_odom: bool
    history: bool
    """Whether states are kept for the service /seek; by default if `show_viz` is set."""
    command_age: float
    models: Tuple[Path, ...]
    state_folder: Optional[Path] = None
    """For relative names of states; if there is one, clients name files in few folders only."""
    launch_file: Optional[Path] = None
    """The launch file that sets the parameters, to check its arguments."""

    @classmethod
    def read(cls) -> "ServerConfig":
        """Reads and checks the parameters.

        Raises:
            FlatlandError: one is missing or invalid.
        """
        world_path = _param("~world_path", "")
        if not world_path:
            raise FlatlandError(_without_world())
        seed = _param("~seed", 0)
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise FlatlandError(f"~seed: expected a whole number of 0 or more, found {seed}")
        simplify_map = _param("~simplify_map", 0)
        if isinstance(simplify_map, bool) or simplify_map not in range(len(TOLERANCES)):
            raise FlatlandError(f"~simplify_map: expected 0, 1 or 2, found {simplify_map}")
        no_return = _param("~no_return", "inf")
        if no_return not in ("inf", "nan", "max"):
            raise FlatlandError(f"~no_return: expected inf, nan or max, found {no_return}")
        show_viz = _flag("~show_viz", True)
        period = _param("~control_period", None)
        launch_file = rospy.get_param("~launch_file", "")
        config = cls(
            world_path=_world_file(str(world_path)),
            update_rate=positive_param("~update_rate", 200.0, allow_infinity=True),
            step_size=positive_param("~step_size", 0.005),
            control_period=None if period is None else _positive("~control_period", period),
            train_mode=_flag("~train_mode", False),
            show_viz=show_viz,
            viz_pub_rate=positive_param("~viz_pub_rate", 30.0),
            seed=seed,
            simplify_map=simplify_map,
            no_return=no_return,
            static_tf=_flag("~static_tf", False),
            tf_by_namespace=_flag("~tf_by_namespace", False),
            wall_clock_stamps=_flag("~wall_clock_stamps", False),
            realtime_priority=_flag("~realtime_priority", True),
            rospy_patches=_flag("~rospy_patches", True),
            map_to_odom=_flag("~map_to_odom", False),
            history=_flag("~history", show_viz),
            command_age=positive_param("~command_age", math.inf, allow_infinity=True),
            models=_folders("~models"),
            state_folder=next(iter(_folders("~state_folder")), None),
            launch_file=Path(launch_file) if launch_file else None,
        )
        if config.wall_clock_stamps:
            _require_real_time(config)
        return config


def _require_real_time(config: ServerConfig) -> None:
    """Refuses what does not go together with stamps of real time."""
    rate = config.update_rate * config.step_size
    if not math.isclose(rate, 1.0, rel_tol=1e-6):
        raise FlatlandError(
            "~wall_clock_stamps: stamps of real time need a simulation in real time, in which "
            f"~update_rate times ~step_size is 1; found {config.update_rate:g} times "
            f"{config.step_size:g}, which is {rate:g}: set ~update_rate to "
            f"{1.0 / config.step_size:g}"
        )
    if config.train_mode:
        raise FlatlandError(
            "~wall_clock_stamps: stamps of real time need a simulation in real time, but with "
            "~train_mode time stands still between calls: leave out one of them"
        )
    if rospy.get_param("/use_sim_time", False):
        raise FlatlandError(
            "~wall_clock_stamps: /use_sim_time is true, with which other nodes wait for /clock; "
            "server.launch sets it to false, or `rosparam delete /use_sim_time` does"
        )


def _param(name: str, default: Any) -> Any:
    """The value of a parameter of the node, else of the namespace above, and so on to the root."""
    value = rospy.get_param(name, default)
    found = rospy.search_param(name[1:]) if value is default else None
    if found is None or found == rospy.resolve_name(name):
        return value
    rospy.loginfo("%s is not set: %s is used", name, found)
    return rospy.get_param(found, default)


def _without_world() -> str:
    """The error of a missing `~world_path`, with the parameters of that name that others have."""
    others = [
        name
        for name in rospy.get_param_names()
        if name.endswith("/world_path") and rospy.get_param(name, "")
    ]
    elsewhere = f"; others are set: {', '.join(others)}" if others else ""
    return (
        "the parameter ~world_path must be the path of a world file: "
        f"world_path:=PATH for roslaunch, _world_path:=PATH for rosrun{elsewhere}"
    )


def _world_file(name: str) -> Path:
    """The absolute path of the world's file; a relative one has to be there."""
    path = to_path(name)
    if not path.is_absolute() and not path.exists():
        raise FlatlandError(
            f"~world_path: there is no file {path.absolute()}; a relative path begins in the "
            "node's working directory, which is not that of roslaunch: write "
            f'"$PWD/{path}" for it'
        )
    return path.absolute()


def _folders(name: str) -> Tuple[Path, ...]:
    """Folders: a list, or separated by colons; each may be a `package://` URI."""
    value = _param(name, "")
    texts = re.split(":(?!//)", value) if isinstance(value, str) else value
    if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
        raise FlatlandError(f"{name}: expected a list of folders, found {value}")
    try:
        folders = tuple(to_path(text).absolute() for text in texts if text.strip())
    except FlatlandError as error:
        raise FlatlandError(f"{name}: {error}") from None
    for folder in folders:
        if not folder.is_dir():
            raise FlatlandError(f"{name}: expected a folder, but {folder} is none")
    return folders


def _flag(name: str, default: bool) -> bool:
    value = _param(name, default)
    if not isinstance(value, int) or value not in (0, 1):  # roslaunch's `if` takes 0 and 1, too
        raise FlatlandError(f"{name}: expected true or false, found {value}")
    return bool(value)


def positive_param(name: str, default: float, *, allow_infinity: bool = False) -> float:
    """A private parameter that is a number above zero.

    Raises:
        FlatlandError: it is something else.
    """
    return _positive(name, _param(name, default), allow_infinity=allow_infinity)


def _positive(name: str, value: Any, *, allow_infinity: bool = False) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if number > 0 and (allow_infinity or math.isfinite(number)):
        return number
    raise FlatlandError(f"{name}: expected a number above 0, found {value}")
