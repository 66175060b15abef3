"""The parameters of the node flatland_server, of ROS 1 and of ROS 2."""

import math
import re
from pathlib import Path
from typing import Any, Callable, Dict, NamedTuple, Optional, Tuple

from flatland_server.config.file_names import to_path
from flatland_server.config.ros_names import is_topic
from flatland_server.config.worlds import shipped_worlds
from flatland_server.exceptions import FlatlandError
from flatland_server.maps.simplify_outlines import TOLERANCES

Get = Callable[[str, Any], Any]
"""Returns the value of a parameter by its name, such as "~seed", and its default."""


class ServerConfig(NamedTuple):
    """The node's parameters."""

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
    map_to_odom: bool
    map: bool
    """Whether the first layer is on /map, as map_server has it."""
    odom_topic: str
    initial_pose: str
    """Name of the model that /initialpose moves; empty if none."""
    history: bool
    """Whether states are kept for the service /seek; by default if `show_viz` is set."""
    command_age: float
    models: Tuple[Path, ...]
    state_folder: Optional[Path] = None
    """For relative names of states; if there is one, clients name files in few folders only."""

    @classmethod
    def read(cls, get: Get) -> "ServerConfig":
        """Reads and checks the parameters.

        Args:
            get: returns the value of a parameter.

        Raises:
            FlatlandError: one is missing or invalid.
        """
        world_path = get("~world_path", "")
        if not world_path:
            raise FlatlandError(
                "the parameter ~world_path must be the path of a world file: world_path:=PATH"
            )
        seed = get("~seed", 0)
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise FlatlandError(f"~seed: expected a whole number of 0 or more, found {seed}")
        simplify_map = get("~simplify_map", 0)
        if isinstance(simplify_map, bool) or simplify_map not in range(len(TOLERANCES)):
            raise FlatlandError(f"~simplify_map: expected 0, 1 or 2, found {simplify_map}")
        no_return = str(get("~no_return", "inf"))  # ROS 2 reads inf and nan as numbers
        if no_return not in ("inf", "nan", "max"):
            raise FlatlandError(f"~no_return: expected inf, nan or max, found {no_return}")
        odom_topic = get("~odom_topic", "odometry/filtered")
        if not isinstance(odom_topic, str) or not is_topic(odom_topic):
            raise FlatlandError(f"~odom_topic: expected the name of a topic, found {odom_topic}")
        show_viz = flag(get, "~show_viz", True)
        period = get("~control_period", None)
        config = cls(
            world_path=_world_file(str(world_path)),
            update_rate=positive_param(get, "~update_rate", 200.0, allow_infinity=True),
            step_size=positive_param(get, "~step_size", 0.005),
            control_period=None if period is None else positive("~control_period", period),
            train_mode=flag(get, "~train_mode", False),
            show_viz=show_viz,
            viz_pub_rate=positive_param(get, "~viz_pub_rate", 30.0),
            seed=seed,
            simplify_map=simplify_map,
            no_return=no_return,
            static_tf=flag(get, "~static_tf", False),
            tf_by_namespace=flag(get, "~tf_by_namespace", False),
            wall_clock_stamps=flag(get, "~wall_clock_stamps", False),
            realtime_priority=flag(get, "~realtime_priority", True),
            map_to_odom=flag(get, "~map_to_odom", False),
            map=flag(get, "~map", False),
            odom_topic=odom_topic,
            initial_pose=str(get("~initial_pose", "")).strip(),
            history=flag(get, "~history", show_viz),
            command_age=positive_param(get, "~command_age", math.inf, allow_infinity=True),
            models=_folders(get, "~models"),
            state_folder=next(iter(_folders(get, "~state_folder")), None),
        )
        if config.wall_clock_stamps:
            _require_real_time(config, get)
        return config

    @property
    def hub(self) -> Dict[str, Any]:
        """Options of `open_hub`."""
        return {
            "view_rate": self.viz_pub_rate if self.show_viz else None,
            "for_rviz": True,
            "map_to_odom": self.map_to_odom,
            "with_map": self.map,
            "initial_pose": self.initial_pose,
            "with_history": self.history,
            "control_period": self.control_period,
            "train_mode": self.train_mode,
        }

    @property
    def params(self) -> Dict[str, Any]:
        """The parameters that plugins read."""
        names = ("no_return", "static_tf", "odom_topic")
        return {f"~{name}": getattr(self, name) for name in names}


def _require_real_time(config: ServerConfig, get: Get) -> None:
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
    if get("/use_sim_time", False):
        raise FlatlandError(
            "~wall_clock_stamps: /use_sim_time is true, with which other nodes wait for /clock; "
            "server.launch sets it to false, or `rosparam delete /use_sim_time` does"
        )


def _world_file(name: str) -> Path:
    """The absolute path of a shipped world, or of a file; a relative one has to be there."""
    path = shipped_worlds().get(name) or to_path(name)
    if not path.is_absolute() and not path.exists():
        raise FlatlandError(
            f"~world_path: there is no file {path.absolute()}; a relative path begins in the "
            "node's working directory, which is not that of roslaunch: write "
            f'"$PWD/{path}" for it'
        )
    return path.absolute()


def _folders(get: Get, name: str) -> Tuple[Path, ...]:
    """Folders: a list, or separated by colons; each may be a `package://` URI."""
    value = get(name, "")
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


def flag(get: Get, name: str, default: bool) -> bool:
    """A parameter that is true or false.

    Args:
        get: returns the value of a parameter by its name; see `ServerConfig.read`.
        name: name of the parameter.
        default: value if the parameter is not set.

    Raises:
        FlatlandError: it is something else.
    """
    value = get(name, default)
    if not isinstance(value, int) or value not in (0, 1):  # roslaunch's `if` takes 0 and 1, too
        raise FlatlandError(f"{name}: expected true or false, found {value}")
    return bool(value)


def positive_param(get: Get, name: str, default: float, *, allow_infinity: bool = False) -> float:
    """A parameter that is a number above zero.

    Args:
        get: returns the value of a parameter by its name; see `ServerConfig.read`.
        name: name of the parameter.
        default: value if the parameter is not set.
        allow_infinity: whether it may be infinite.

    Raises:
        FlatlandError: it is something else.
    """
    return positive(name, get(name, default), allow_infinity=allow_infinity)


def positive(name: str, value: Any, *, allow_infinity: bool = False) -> float:
    """A number above zero.

    Args:
        name: name of the parameter, for the error.
        value: value of the parameter.
        allow_infinity: whether it may be infinite.

    Raises:
        FlatlandError: it is something else.
    """
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if number > 0 and (allow_infinity or math.isfinite(number)):
        return number
    raise FlatlandError(f"{name}: expected a number above 0, found {value}")
