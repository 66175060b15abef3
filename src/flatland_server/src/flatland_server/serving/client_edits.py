"""The changes that clients have made to a world's models, for /save_world and for viewers."""

from dataclasses import replace
from typing import Dict, List, NamedTuple, Optional, Tuple

from flatland_server.config.ros_names import bare_namespace
from flatland_server.geometry import Pose
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry
from flatland_server.simulation.world_contents import WorldContents

_DIGITS = 4
"""Of poses in world files: tenths of a millimetre."""

_ORIGIN = Pose()


class Changes(NamedTuple):
    """The difference between a world's file and what clients have made of it."""

    poses: Dict[str, Pose]
    """The new poses of models of the file."""
    deleted: List[str]
    """Models of the file."""
    added: List[ModelEntry]

    @property
    def number(self) -> int:
        """The number of models that differ."""
        return len(self.poses) + len({*self.deleted, *(entry.name for entry in self.added)})


class ClientEdits:
    """Notes moves, spawns and deletions by clients; what robots and plugins do is none of them.

    An edit that is undone is no change any more. A reset undoes all of them.

    Args:
        world: has the models.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._contents: Optional[WorldContents] = None
        self._poses: Dict[str, Pose] = {}
        self._deleted: Dict[str, ModelEntry] = {}  # of the file
        self._added: Dict[str, ModelEntry] = {}

    def note_move(self, name: str, pose: Pose) -> None:
        """Notes that a client has put a model at a pose."""
        self._follow()
        self._poses[name] = pose

    def note_spawn(self, entry: ModelEntry) -> None:
        """Notes that a client has added a model."""
        self._follow()
        former = self._deleted.get(entry.name)
        if (
            former is not None
            and former.namespace == entry.namespace
            and _file(former) == _file(entry)
        ):
            del self._deleted[entry.name]  # it is back
        else:
            self._added[entry.name] = entry
        self._poses[entry.name] = entry.pose

    def note_deletion(self, name: str) -> None:
        """Notes that a client has deleted a model."""
        self._follow()
        self._poses.pop(name, None)
        if self._added.pop(name, None) is None:
            self._deleted.update((each.name, each) for each in self._entries if each.name == name)

    def clear(self) -> None:
        """Forgets all edits: they are in the file."""
        self._contents = self._world.contents
        for noted in (self._poses, self._deleted, self._added):
            noted.clear()

    @property
    def changes(self) -> Changes:
        """The present difference."""
        self._follow()
        models = self._world.models
        former = {entry.name: entry.pose for entry in self._entries}
        poses = {
            name: nearest(former[name], pose)
            for name, pose in self._poses.items()
            if name in models and name in former and name not in self._added
        }
        return Changes(
            {name: pose for name, pose in poses.items() if pose != former[name]},
            list(self._deleted),
            [
                replace(entry, pose=nearest(_ORIGIN, self._poses[entry.name]))
                for entry in self._added.values()
                if entry.name in models
            ],
        )

    @property
    def count(self) -> int:
        """The number of models that differ from the file."""
        if not (self._poses or self._deleted or self._added):
            return 0
        return self.changes.number

    @property
    def _entries(self) -> Tuple[ModelEntry, ...]:
        return self._world.config.models

    def _follow(self) -> None:
        """Forgets what a reset, a reload or a loaded state has undone."""
        if self._contents is self._world.contents:
            return
        self._contents = self._world.contents
        models = self._world.models
        for name in [name for name in self._deleted if name in models]:
            del self._deleted[name]
        for name, entry in list(self._added.items()):
            if name not in models or models[name].namespace != bare_namespace(entry.namespace):
                del self._added[name]  # gone, or replaced by the file's
        for name, pose in list(self._poses.items()):
            if name not in models or nearest(pose, models[name].pose) != pose:
                del self._poses[name]
        for entry in self._added.values():
            self._poses.setdefault(entry.name, entry.pose)


def nearest(former: Pose, pose: Pose) -> Pose:
    """A pose as a file has it: rounded, and the former numbers where they are equal to that."""
    return Pose(
        *(
            before if abs(before - now) <= 0.5 * 10**-_DIGITS else round(now, _DIGITS)
            for before, now in zip(former, pose)
        )
    )


def _file(entry: ModelEntry) -> object:
    return entry.model.path if entry.model.content is None else entry.model.content
