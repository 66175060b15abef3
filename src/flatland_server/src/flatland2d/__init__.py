"""The short name of the library: `from flatland2d import Simulation`.

All that `flatland_server` exports, and nothing of its own.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flatland_server import *  # noqa: F403
    from flatland_server import __all__ as __all__


def __getattr__(name: str) -> Any:
    """Imports `flatland_server` at the first use.

    Not before: in catkin's devel space, while this file is executed, that would be the package in
    the source tree, without the extension module.
    """
    import flatland_server

    return getattr(flatland_server, name)
