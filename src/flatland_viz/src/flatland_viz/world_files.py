"""A world's files: their names as the window shows them, and whether they are the user's."""

import os
import re
from pathlib import Path

_SUFFIX = ".model.yaml"
_OWN_PACKAGE = re.compile(r"<name>\s*flatland")


def label(model: Path) -> str:
    """The name of a model file in a menu."""
    name = model.name
    return name[: -len(_SUFFIX)] if name.endswith(_SUFFIX) else model.stem


def title(world: str) -> str:
    """The window's title: a world's file with its folder, since many are called world.yaml.

    Qt puts its mark of unsaved changes in place of "[*]".

    Args:
        world: the path; empty if it is unknown.
    """
    return f"Flatland - {'/'.join(Path(world).parts[-2:])}[*]" if world else "Flatland[*]"


def is_installed(world: Path) -> bool:
    """True if a world's file is not the user's to change.

    It is one of Flatland's packages, or of an install space, which the next build overwrites; or it
    cannot be written. False if it is on another machine.
    """
    world = world.resolve()
    if not world.exists():
        return False
    manifests = (parent / "package.xml" for parent in world.parents)
    manifest = next((each for each in manifests if each.exists()), None)
    if manifest is not None:
        text = manifest.read_text(errors="replace")
        if manifest.parents[1].name == "share" or _OWN_PACKAGE.search(text):
            return True
    return not all(os.access(each, os.W_OK) for each in (world, world.parent))


def copy_of(world: Path) -> Path:
    """A name for a copy of a world in the user's home: that of its folder for a world.yaml."""
    name = world.parent.name if world.stem == "world" else world.stem
    return Path.home() / f"{name or 'world'}.yaml"
