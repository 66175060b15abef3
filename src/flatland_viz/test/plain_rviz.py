"""Plain rviz with windows that have a size when OpenGL asks for it."""

import subprocess
from pathlib import Path
from typing import List


def steady_windows(folder: Path) -> str:
    """The library that is made of `rviz_windows.c` in this folder, for LD_PRELOAD."""
    library = folder / "rviz_windows.so"
    source = Path(__file__).with_name("rviz_windows.c")
    subprocess.run(["gcc", "-shared", "-fPIC", "-O1", "-o", library, source], check=True)
    return str(library)


def plain_rviz(folder: Path) -> List[str]:
    """The command of plain rviz with that library."""
    return ["env", f"LD_PRELOAD={steady_windows(folder)}", "rviz"]
