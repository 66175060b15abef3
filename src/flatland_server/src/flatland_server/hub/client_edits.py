"""The changes that clients have made to a world's models, for /save_world and for viewers."""

import os
from dataclasses import replace
from typing import Dict, Iterable, List, NamedTuple, Tuple

from flatland_server.geometry import Pose
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry

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

    def applied_to(self, models: Iterable[ModelEntry]) -> Tuple[ModelEntry, ...]:
        """The models of a file with these changes.

        Args:
            models: of the file.
        """
        kept = [
            replace(entry, pose=self.poses.get(entry.name, entry.pose))
            for entry in models
            if entry.name not in self.deleted
        ]
        return (*kept, *self.added)


class ClientEdits:
    """Moves, spawns and deletions by clients; what robots and plugins do is none of them.

    They are noted in the world's contents, and are compared with its file when they are asked for.
    So an edit that is undone is no change, a reset undoes all of them, and a loaded state has those
    that it was saved with.

    Args:
        world: has the models.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def note_move(self, name: str, pose: Pose) -> None:
        """Notes that a client has put a model at a pose."""
        layout = self._world.contents.layout
        if name in layout:  # else it is a plugin's
            layout[name] = pose

    def note_spawn(self, entry: ModelEntry) -> None:
        """Notes that a client has added a model."""
        self._world.contents.layout[entry.name] = entry.pose

    def note_deletion(self, name: str) -> None:
        """Notes that a client has deleted a model."""
        self._world.contents.layout.pop(name, None)

    @property
    def changes(self) -> Changes:
        """The present difference."""
        contents = self._world.contents
        layout, present = contents.layout, contents.additions.entries
        changes = Changes({}, [], [])
        former = {entry.name: entry for entry in contents.config.models}
        for name, pose in layout.items():
            entry, before = present.get(name), former.get(name)
            if before is not None and (entry is None or _is_same(entry, before)):
                del former[name]
                if pose != before.pose and nearest(before.pose, pose) != before.pose:
                    changes.poses[name] = nearest(before.pose, pose)
            elif entry is not None:  # else a plugin has deleted what a client had spawned
                changes.added.append(replace(entry, pose=nearest(_ORIGIN, pose)))
        changes.deleted.extend(former)
        return changes

    @property
    def count(self) -> int:
        """The number of models that differ from the file."""
        return self.changes.number


def nearest(former: Pose, pose: Pose) -> Pose:
    """A pose as a file has it: rounded, and the former numbers where they are equal to that."""
    return Pose(
        *(
            before if abs(before - now) <= 0.5 * 10**-_DIGITS else round(now, _DIGITS)
            for before, now in zip(former, pose)
        )
    )


def _is_same(entry: ModelEntry, other: ModelEntry) -> bool:
    """True if models of two entries differ in their poses at most."""
    model, before = entry.model, other.model
    return entry is other or (
        entry.namespace == other.namespace
        and model.content == before.content
        and (
            model.path == before.path
            or os.path.realpath(model.path) == os.path.realpath(before.path)
        )
    )
