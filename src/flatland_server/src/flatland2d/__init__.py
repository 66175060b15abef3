"""Flatland, a 2D robot simulator: the public interface under the name of its distribution.

from flatland2d import Simulation
"""

from flatland_server import *  # noqa: F403
from flatland_server import __all__ as __all__
