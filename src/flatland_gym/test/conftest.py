import pytest


@pytest.fixture
def without_screen(monkeypatch):
    """No screen, hence no browser."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
