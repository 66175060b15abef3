"""The short name of the library: `from flatland2d import Simulation`.

All that `flatland_server` exports, and nothing of its own.
"""

from flatland_server import *  # noqa: F403
from flatland_server import __all__ as __all__
from flatland_server import __version__ as __version__
