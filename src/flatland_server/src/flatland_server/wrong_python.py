"""The error of an import by a Python that the catkin workspace was not built for."""

import os
import sys
from pathlib import Path


def wrong_python(error: ImportError) -> BaseException:
    """The error to raise for one of an import, with its cause if that is a sourced `setup.bash`.

    Ctrl-C while the core is loaded is an ImportError, too, and is raised as what it was.

    setup.bash puts the workspace into PYTHONPATH, which comes before the packages of a virtual
    environment, of pyenv and of conda.
    """
    if isinstance(error.__cause__, KeyboardInterrupt):
        return error.__cause__
    folders = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    built = [each for each in folders if each and Path(each, "flatland_server").is_dir()]
    if not built:
        return error
    return ImportError(
        f"this is the catkin workspace's build ({built[0]}), and {sys.executable} cannot use it: "
        f"use /usr/bin/python3, or a terminal without setup.bash ({error})"
    )
