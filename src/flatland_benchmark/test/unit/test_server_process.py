"""The environment of a benchmark's programs."""

import tempfile
from pathlib import Path

from flatland_benchmark.server_process import ServerProcess


def test_programs_do_not_read_the_users_settings(monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", "/users/settings")
    benchmark = ServerProcess(Path("world.yaml"))

    folder = Path(benchmark.call("settings", ["printenv", "XDG_CONFIG_HOME"]).strip())

    assert folder.parent == Path(tempfile.gettempdir())
