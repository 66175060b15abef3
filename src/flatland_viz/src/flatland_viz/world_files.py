"""Names of a world's files, as the window shows them."""

from pathlib import Path

_SUFFIX = ".model.yaml"


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
