"""The programs of all packages, before they have imported anything."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGES = Path(__file__).parents[3]
NODES = [node for node in sorted(PACKAGES.glob("*/nodes/*")) if node.name != "flatland_benchmark"]


@pytest.mark.parametrize("node", NODES, ids=lambda node: node.name)
def test_ctrl_c_during_imports_is_quiet(node, tmp_path):
    for name in ("rospy", *(each.name for each in PACKAGES.iterdir())):
        (tmp_path / f"{name}.py").write_text(
            "import os, time; os.kill(os.getpid(), 2); time.sleep(9)"
        )

    process = subprocess.run(
        [sys.executable, node],
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )

    assert process.stderr == b""
    assert process.returncode in (130, -signal.SIGINT)
