"""Processes that multiprocessing has spawned find the package, as catkin has built it."""

import json
import subprocess
import sys


def test_a_spawned_process_can_import_what_this_one_has_imported():
    # A spawned process first runs multiprocessing.spawn.prepare(), and then the function.
    program = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); import flatland_server"
    result = subprocess.run(
        [sys.executable, "-c", program, json.dumps(sys.path)],
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
    )
    assert result.returncode == 0, result.stderr
