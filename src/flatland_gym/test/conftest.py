import pytest


@pytest.fixture
def without_screen(monkeypatch):
    """No screen, but pygame."""
    pytest.importorskip("pygame")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
