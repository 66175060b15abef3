"""The window on small screens and at double size, and what it remembers."""

import re
from pathlib import Path

import pytest
from desktop import desktop

pytestmark = pytest.mark.slow

ROOM = Path(__file__).resolve().parents[2] / "flatland_server/worlds/test_room/world.yaml"
TITLE = "Flatland - test_room/world.yaml"
WIDTH, HEIGHT = 1024, 700
KNOB = (60, 130, 196)
SELECTED = (70, 76, 84)
FIRST_ROW = {1: 86, 2: 165}  # of the list of models, from the top of the screen [px], by scale
DARK = (18, 19, 22)
PALE = (
    147,
    147,
    147,
)  # what the room's walls are on it; on a light background they are (102, 102, 102)


@pytest.fixture(scope="module")
def display():
    with desktop(f"{WIDTH}x{HEIGHT}") as name:
        yield name


@pytest.fixture(scope="module")
def server(ros):
    return ros.launch_server(ROOM, "show_viz:=true", "use_rviz:=true")


@pytest.fixture
def open_window(ros, screen):
    """Opens the window; it is closed after the test."""
    programs = []

    def start(scale):
        command = ("env", f"QT_SCALE_FACTOR={scale}", "rosrun", "flatland_viz", "flatland_viz")
        programs.append(ros.start(*command))
        return screen.wait_for_window(TITLE)

    yield start
    for program in programs:
        ros.end(program)


def frame_of(screen, window):
    """Width, height, x and y of a window with its title bar [px]."""
    text = "\n".join(screen.text("xwininfo", "-id", window, "-frame", "-stats"))
    fields = ("Width", "Height", "Absolute upper-left X", "Absolute upper-left Y")
    return tuple(int(re.search(rf"{field}: +(-?\d+)", text)[1]) for field in fields)


def is_dark(pixels):
    return (abs(pixels - DARK).max(axis=2) < 3).mean() > 0.2


def has_pale_walls(pixels):
    return (abs(pixels - PALE).max(axis=2) < 6).sum() > 300


def has_selected_row(pixels):
    return (abs(pixels[:, WIDTH // 2 :] - SELECTED).max(axis=2) < 3).sum() > 1000


def has_pad(pixels):
    """Whether the Drive panel is shown, with its knob."""
    return (abs(pixels[:, WIDTH // 2 :] - KNOB).max(axis=2) < 3).sum() > 300


@pytest.mark.parametrize("scale", [1, 2])
def test_the_window_fits_and_remembers(server, open_window, screen, waiting, ros, scale):
    window = open_window(scale)

    def is_within_the_screen():
        width, height, x, y = frame_of(screen, window)
        return x + width <= WIDTH and y + height <= HEIGHT

    assert is_within_the_screen()
    name = f"small_{scale}x"

    def selects():
        screen.click((WIDTH - 200 * scale, FIRST_ROW[scale]))
        return has_selected_row(screen.picture(f"{name}_selected"))

    waiting(selects, "a selected model", 20)
    assert is_within_the_screen()
    if scale == 1:
        screen.key("alt+v", "b", "d")
    waiting(lambda: is_dark(screen.picture(name)), "the dark background", 30)
    waiting(lambda: has_pale_walls(screen.picture(name)), "walls that stand out on it", 20)
    screen.key("F4")
    waiting(lambda: has_pad(screen.picture(f"{name}_drive")), "the pad to drive", 20)
    assert is_within_the_screen()
    screen.key("F4", "F1")
    screen.wait_for_window("Keys and Mouse")
    width, height, *_ = frame_of(screen, screen.windows("Keys and Mouse")[-1])
    assert width <= WIDTH
    assert height <= HEIGHT
    screen.picture(f"{name}_keys")
    screen.key("Escape")
    screen.wait_until_closed("Keys and Mouse")
    screen.focus(window)
    screen.key("ctrl+q")
    screen.wait_until_closed(TITLE)


def test_a_world_that_is_refused_opens_no_window(run, screen, display, tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("properties: {}\nlayers: []\nmodels: [{name: a, model: nowhere.model.yaml}]\n")
    launch = run(str(world), display=display)
    seen = set()
    while launch.process.poll() is None:
        seen.update(screen.windows("Flatland.*"))
    assert launch.process.returncode != 0
    assert "nowhere.model.yaml" in launch.output
    assert not seen
