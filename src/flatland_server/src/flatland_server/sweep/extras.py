"""How to install what sweeps need besides the library: it depends on how that was installed."""

import sys
from importlib import metadata

_DISTRIBUTION = "flatland2d"


def how_to_install(extra: str, package: str) -> str:
    """What a user of this Python has to run to get a package of PyPI.

    pip knows the extra if the library itself was installed by pip. In a ROS workspace it was not,
    and Debian's Python accepts packages of PyPI in a virtual environment only: there, one that also
    has the system's packages.

    Args:
        extra: of the library for pip.
        package: that the extra consists of.
    """
    if _is_installed(_DISTRIBUTION):
        return f"pip install '{_DISTRIBUTION}[{extra}]'"
    if sys.prefix != sys.base_prefix:
        return f"pip install {package}"
    return (
        f"python3 -m venv --system-site-packages ~/flatland-venv; ~/flatland-venv/bin/pip install "
        f"{package}; ~/flatland-venv/bin/python3 -m flatland_server sweep ..."
    )


def _is_installed(distribution: str) -> bool:
    try:
        metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return False
    return True
