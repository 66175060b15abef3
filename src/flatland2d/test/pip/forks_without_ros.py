"""scripts/guide/forks.py in a Python in which there is no ROS.

usage: forks_without_ros.py SOCKET
"""

import runpy
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]
sys.path.insert(0, str(ROOT / "src" / "flatland_server" / "test" / "unit"))

from without_ros import BLOCK_ROS  # noqa: E402 - after its folder

exec(BLOCK_ROS)
runpy.run_path(str(ROOT / "scripts" / "guide" / "forks.py"), run_name="__main__")
