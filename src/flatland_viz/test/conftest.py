"""The window on virtual screens, and ROS programs. A module has one server: see `screens`."""

from pathlib import Path

import pytest
from desktop import desktop
from gui_screen import Screen, wait_until
from ros_programs import Ros
from screens import SCREENS, chosen, screens_option

ROOT = Path(__file__).resolve().parents[3]
OFFICE = ROOT / "src" / "flatland_server" / "worlds" / "office"


def pytest_addoption(parser):
    parser.addoption(
        "--screens",
        default="usual",
        type=screens_option,
        metavar="NAMES",
        help="screens that each test of the window runs on: all, or "
        f"{', '.join(SCREENS)} with commas between them; otherwise each module runs on its own",
    )


def pytest_generate_tests(metafunc):
    """Gives each test of a window its module's viewers and screens."""
    if "screen" not in metafunc.fixturenames:
        return
    module = Path(metafunc.module.__file__).stem
    pairs = chosen(module, metafunc.config.getoption("screens", "usual"))
    ids = [screen if viewer == "window" else f"{viewer}-{screen}" for viewer, screen in pairs]
    metafunc.parametrize("viewer_and_screen", pairs, ids=ids, indirect=True, scope="module")


@pytest.fixture(scope="module")
def viewer_and_screen(request):
    """The program that shows the world, "window" or "rviz", and the name of its screen."""
    return request.param


@pytest.fixture(scope="module")
def screen(viewer_and_screen, tmp_path_factory):
    _, name = viewer_and_screen
    kind = SCREENS[name]
    with desktop(kind.width, kind.height) as display:
        screen = Screen(display, kind, name, tmp_path_factory.mktemp("config"))
        yield screen
        screen.save_pictures()


@pytest.fixture(scope="module")
def ros(screen, tmp_path_factory):
    ros = Ros(screen.environment, tmp_path_factory.mktemp("ros"))
    yield ros
    ros.close()


@pytest.fixture(scope="module")
def waiting():
    """The function `wait_until`."""
    return wait_until


@pytest.fixture(scope="module")
def office():
    """The folder of the office world."""
    return OFFICE
