"""The files of a world: the models that can be spawned."""

from pathlib import Path
from typing import Any, List

import yaml

_SUFFIX = ".model.yaml"


def model_files(world: Path) -> List[Path]:
    """The model files in a world's folder and those named in its file, each once.

    Only the server evaluates world files. This finds the models that are named literally; a missing
    file, or one that is not plain YAML, gives none.
    """
    try:
        beside = sorted(world.parent.glob(f"*{_SUFFIX}"))
        named = [(world.parent / name) for name in _named_models(world)]
    except OSError:
        return []
    files: List[Path] = []
    for file in [*beside, *named]:
        path = file.resolve()
        if path not in files and path.is_file():
            files.append(path)
    return files


def _named_models(world: Path) -> List[str]:
    try:
        content: Any = yaml.load(world.read_text(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, UnicodeDecodeError):
        return []
    models = content.get("models") if isinstance(content, dict) else None
    if not isinstance(models, list):
        return []
    names = [entry.get("model") for entry in models if isinstance(entry, dict)]
    return [name for name in names if isinstance(name, str)]


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
