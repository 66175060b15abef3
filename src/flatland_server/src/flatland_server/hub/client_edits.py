"""The changes that clients make to a world's models: undone, redone, and saved by /save_world."""

import os
from contextlib import contextmanager
from dataclasses import replace
from typing import Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

from flatland_server.exceptions import FlatlandError, ModelError, counted
from flatland_server.geometry import Pose
from flatland_server.models.model import Model
from flatland_server.simulation.world import World
from flatland_server.simulation.world_config import ModelEntry

_DIGITS = 4
"""Of poses in world files: tenths of a millimetre."""

_ORIGIN = Pose()

_MOST_EDITS = 100
"""Edits that can be undone."""


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
        """The models of a file with these changes."""
        kept = [
            replace(entry, pose=self.poses.get(entry.name, entry.pose))
            for entry in models
            if entry.name not in self.deleted
        ]
        return (*kept, *self.added)


class _Placed(NamedTuple):
    """A model in the world."""

    entry: ModelEntry
    """With its present pose."""
    layout: Optional[Pose]
    """Its pose as the world's file has it, with the edits so far; None if it is a plugin's."""


class Edit:
    """One action of a client.

    Attributes:
        before: the models that it concerns, by name; None if there was none of the name.
        after: the same, after the action.
    """

    def __init__(self, before: Dict[str, Optional[_Placed]]) -> None:
        self.before = self.after = before

    @property
    def text(self) -> str:
        """The name of the action, such as `Move r2`."""
        names = list(self.before)
        what = names[0] if len(names) == 1 else counted(len(names), "model")
        if not any(self.before.values()):
            return f"Spawn {what}"
        return f"Move {what}" if any(self.after.values()) else f"Delete {what}"

    @property
    def is_empty(self) -> bool:
        """True if the models are as they were."""
        return all(_is_at(place, self.after[name]) for name, place in self.before.items())


class ClientEdits:
    """Moves, spawns and deletions by clients; what robots and plugins do is none of them.

    They are noted in the world's contents, and are compared with its file when they are asked for.
    So an edit that is undone is no change, a reset undoes all of them, and a loaded state has those
    that it was saved with. With other contents, there is nothing to undo.

    Attributes:
        revision: counts edits, also those that are undone and redone.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._contents = world.contents
        self._done: List[Edit] = []  # the latest last
        self._undone: List[Edit] = []
        self.revision = 0

    @contextmanager
    def edit(self, names: Iterable[str], extends: Optional[Edit] = None) -> Iterator[Edit]:
        """A context; the changes of models within it are one edit. If it fails, none is spawned.

        Args:
            names: names of the models that may change.
            extends: an edit of the same models, such as the beginning of a drag. If it is still the
                latest, the changes are a part of it.
        """
        self._follow_contents()
        done = self._done
        is_part = extends is not None and bool(done) and done[-1] is extends
        edit = done[-1] if is_part else Edit({name: self._placed(name) for name in names})
        with self._spawning_all():
            yield edit
        edit.after = {name: self._placed(name) for name in edit.before}
        if is_part:
            done.pop()
        if not edit.is_empty:
            done.append(edit)
            del done[:-_MOST_EDITS]
            self._undone.clear()
        self.revision += 1

    def move(self, name: str, pose: Pose, extends: Optional[Edit] = None) -> Edit:
        """Moves a model.

        Args:
            name: the model's name.
            pose: new pose of the model's origin [m, m, rad].
            extends: as for `edit`.

        Raises:
            ModelError: there is no such model, or the pose is outside the limits of worlds.
        """
        with self.edit([name], extends) as edit:
            self._world.move_model(name, pose)
            layout = self._world.contents.layout
            if name in layout:
                layout[name] = pose
        return edit

    def spawn(self, entry: ModelEntry) -> Model:
        """Adds a model, within a context `edit`.

        Raises:
            FlatlandError: it cannot be added.
        """
        model = self._world.add_model(entry)
        self._world.contents.layout[entry.name] = entry.pose
        return model

    def delete(self, names: Iterable[str]) -> None:
        """Deletes models, unless plugins of one have deleted another."""
        names = list(names)
        with self.edit(names):
            self.discard(names)

    def discard(self, names: Iterable[str]) -> None:
        """Deletes models for ever, like `delete`."""
        for name in names:
            self._world.contents.layout.pop(name, None)
            if name in self._world.models:
                self._world.delete_model(name)

    def undo(self) -> str:
        """Undoes the latest edit; returns its name.

        Raises:
            FlatlandError: there is none, or models have changed so that it cannot be undone.
        """
        self._follow_contents()
        if not self._done:
            raise FlatlandError("there is nothing to undo")
        edit = self._done.pop()
        self._make(edit.before, edit.after)
        self._undone.append(edit)
        return edit.text

    def redo(self) -> str:
        """Does again what was undone last; returns its name.

        Raises:
            FlatlandError: as for `undo`.
        """
        self._follow_contents()
        if not self._undone:
            raise FlatlandError("there is nothing to redo")
        edit = self._undone.pop()
        self._make(edit.after, edit.before)
        self._done.append(edit)
        return edit.text

    @property
    def next_texts(self) -> Tuple[str, str]:
        """The names of the next edits to undo and to redo, empty where there is none."""
        self._follow_contents()
        undo, redo = (edits[-1].text if edits else "" for edits in (self._done, self._undone))
        return undo, redo

    def _follow_contents(self) -> None:
        if self._contents is not self._world.contents:
            self._contents = self._world.contents
            self._done.clear()
            self._undone.clear()

    def _placed(self, name: str) -> Optional[_Placed]:
        contents = self._world.contents
        if name not in contents.models:
            return None
        entry = replace(contents.added.entries[name], pose=contents.models[name].pose)
        return _Placed(entry, contents.layout.get(name))

    @contextmanager
    def _spawning_all(self) -> Iterator[None]:
        """A context; all models that are spawned within it are deleted if it fails."""
        before = set(self._world.models)
        try:
            yield
        except BaseException:
            self.discard([name for name in self._world.models if name not in before])
            raise

    def _make(
        self, places: Dict[str, Optional[_Placed]], former: Dict[str, Optional[_Placed]]
    ) -> None:
        """Spawns, moves and deletes models: all or none.

        Args:
            places: models and poses as they are to be, by name.
            former: as an edit has left them; else none is touched.
        """
        world = self._world
        layout = world.contents.layout
        self.revision += 1
        for name, place in former.items():
            if (name in world.models) != (place is not None):
                is_there = "there is a" if name in world.models else "there is no"
                raise ModelError(f'{is_there} model named "{name}" meanwhile')
        with self._spawning_all():
            for name, place in places.items():
                if place is None:
                    self.discard([name])
                    continue
                if name in world.models:  # also if plugins of another one have spawned it
                    world.move_model(name, place.entry.pose)
                else:
                    world.add_model(place.entry)
                layout.pop(name, None)
                if place.layout is not None:
                    layout[name] = place.layout

    @property
    def changes(self) -> Changes:
        """The present difference."""
        contents = self._world.contents
        layout, present = contents.layout, contents.added.entries
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


def _is_at(place: Optional[_Placed], other: Optional[_Placed]) -> bool:
    """True if a model is where it was; or neither place has one."""
    if place is None or other is None:
        return place is other
    before, after = place.entry.pose, other.entry.pose
    return nearest(before, after) == before


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
