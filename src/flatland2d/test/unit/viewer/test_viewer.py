"""Effects of the window's keys and of the mouse, without a window."""

import math

import numpy as np
import pytest

from flatland2d.simulation import Simulation
from flatland2d.viewer.trail import Trail
from flatland2d.viewer.viewer import Viewer
from flatland_server.exceptions import FlatlandError
from flatland_teleop.driving_keys import Direction

SIZE = (400, 300)
DRIVES = {
    "diff": {"type": "DiffDrive", "name": "drive", "body": "base"},
    "omni": {"type": "OmniDrive", "name": "drive", "body": "base"},
}


def model(plugins):
    disc = {"type": "circle", "radius": 0.3, "density": 1}
    return {
        "bodies": [{"name": "base", "color": [1, 0, 0, 1], "footprints": [disc]}],
        "plugins": plugins,
    }


@pytest.fixture
def simulation():
    """A stone at the origin, and two robots to its left and right, 8 m apart."""
    models = [
        {"name": "stone", "model": model([])},
        {"name": "diff", "pose": [-4, 0, 0], "model": model([DRIVES["diff"]])},
        {"name": "omni", "pose": [4, 0, 0], "model": model([DRIVES["omni"]])},
    ]
    world = {"properties": {}, "layers": [], "models": models}
    with Simulation(world, raise_failures=False) as simulation:
        yield simulation


class Keys:
    """Holds keys, as the window reports them at each frame."""

    def __init__(self, viewer):
        self.viewer = viewer

    def hold(self, seconds=0.0, is_slow=False, **parts):
        self.viewer.drive.command(self.viewer.chosen, Direction(**parts), is_slow=is_slow)
        for _ in range(round(seconds / 0.05)):
            self.viewer.advance(0.05)


@pytest.fixture
def viewer(simulation):
    return Viewer(simulation, SIZE, clock=lambda: 0.0)


@pytest.fixture
def keys(viewer):
    return Keys(viewer)


def test_the_first_robot_is_chosen_and_the_whole_world_shown(viewer):
    assert viewer.chosen == "diff"
    assert not viewer.is_following
    assert viewer.view.center == pytest.approx((0, 0), abs=0.05)


def test_keys_drive_the_robot_until_they_are_released(viewer, keys, simulation):
    keys.hold(1.0, forwards=1.0)
    assert simulation.models["diff"].pose.x == pytest.approx(-3.5, abs=0.01)

    keys.hold(2.0, forwards=1.0, is_slow=True)
    assert simulation.models["diff"].pose.x == pytest.approx(-3.0, abs=0.02)

    keys.hold(1.0)
    assert simulation.models["diff"].pose.x == pytest.approx(-3.0, abs=0.02)

    keys.hold(1.0, turn=-1.0)
    assert simulation.models["diff"].pose.yaw == pytest.approx(-1.0, abs=0.01)


def test_a_robot_that_can_moves_sideways(viewer, keys, simulation):
    viewer.choose("omni")

    keys.hold(1.0, left=1.0)

    assert simulation.models["omni"].pose.y == pytest.approx(0.5, abs=0.01)


def test_a_robot_is_stopped_when_another_one_is_chosen(viewer, keys, simulation):
    keys.hold(0.2, forwards=1.0)
    viewer.choose("omni")
    keys.hold(0.2, forwards=1.0)

    assert simulation.models["diff"].velocity.vx == pytest.approx(0.0, abs=1e-6)
    assert simulation.models["omni"].velocity.vx == pytest.approx(0.5, abs=1e-6)


def test_a_robot_is_not_commanded_while_no_key_is_held(viewer, keys, simulation):
    simulation.models["diff"].command(0.3, 0.0)

    keys.hold(0.5)

    assert simulation.models["diff"].velocity.vx == pytest.approx(0.3, abs=1e-6)


def test_models_without_a_drive_take_no_keys(viewer, keys, simulation):
    viewer.choose("stone")

    keys.hold(0.5, forwards=1.0)

    assert simulation.models["stone"].pose.x == 0.0


def test_the_past_can_be_looked_at_and_the_run_goes_on_as_it_was(viewer, keys, simulation):
    keys.hold(1.0, forwards=1.0)
    keys.hold(2.0, forwards=1.0, turn=1.0)
    poses = simulation.poses

    viewer.seek(0.5)
    assert simulation.models["diff"].pose.x == pytest.approx(-3.75, abs=0.01)
    assert viewer.status()[0].startswith("0.50 of 3.00 s   paused")
    assert not viewer.takes_commands
    viewer.single_step()
    viewer.seek_by(1.0)
    viewer.seek_by(-0.005)
    assert simulation.time == pytest.approx(1.5)
    viewer.seek_by(20.0)

    assert (simulation.poses == poses).all()
    assert simulation.time == viewer.timeline.end == pytest.approx(3.0)
    assert viewer.timeline.fraction == 1.0
    assert viewer.takes_commands


def test_another_run_begins_in_the_past_with_the_keys_that_are_held_then(viewer, keys, simulation):
    keys.hold(3.0, forwards=1.0)
    viewer.seek(viewer.timeline.time_at(0.5))
    viewer.toggle_pause()
    assert viewer.status()[0].endswith("goes on from 1.50 s")

    keys.hold(1.0)

    assert simulation.models["diff"].pose.x == pytest.approx(-3.25, abs=0.01)
    assert viewer.timeline.end == pytest.approx(2.5)


def test_a_robot_that_keys_have_not_driven_goes_on_in_the_past(viewer, keys, simulation):
    simulation.models["diff"].command(0.3, 0.0)
    keys.hold(3.0)
    viewer.seek(1.0)
    viewer.toggle_pause()

    keys.hold(1.0)

    assert simulation.models["diff"].velocity.vx == pytest.approx(0.3, abs=1e-6)


def test_a_world_that_cannot_be_saved_is_shown_without_its_past(simulation, monkeypatch):
    def fail(drive):
        raise ValueError("no state")

    monkeypatch.setattr(type(simulation.models["diff"].plugin("drive")), "get_state", fail)
    viewer = Viewer(simulation, SIZE, clock=lambda: 0.0)
    viewer.advance(0.05)
    viewer.seek_by(-0.02)

    assert simulation.time == pytest.approx(0.05)
    assert 'the plugin "diff/drive": get_state: ValueError: no state' in viewer.status()[0]


def test_tab_follows_one_robot_after_the_other(viewer):
    found = []
    for step in (1, 1, 1, -1):
        viewer.choose_next(step)
        found.append((viewer.chosen, viewer.is_following))

    assert found == [("diff", True), ("omni", True), ("diff", True), ("omni", True)]


def test_what_is_followed_is_in_the_middle(viewer, simulation):
    viewer.choose_next()
    simulation.move("diff", (-1.5, 2.0, 0.0))

    picture = viewer.image()

    assert viewer.view.center == pytest.approx((-1.5, 2.0), abs=1 / viewer.view.scale)
    assert picture.getpixel((200, 150 + 3)) == (255, 0, 0)


@pytest.mark.parametrize(
    ("position", "chosen"), [((4.1, 0.1), "omni"), ((0, 0.2), "stone"), ((2, 2), "diff")]
)
def test_a_click_chooses_the_model_below_it(viewer, position, chosen):
    viewer.choose_at(tuple(viewer.view.pixels([position])[0]))

    assert viewer.chosen == chosen
    assert viewer.is_following == (chosen != "diff")


def test_dragging_moves_the_picture_and_ends_following(viewer):
    viewer.choose_next()
    viewer.image()
    before = viewer.view.center

    viewer.pan(40, 0)

    assert not viewer.is_following
    assert viewer.view.center[0] == pytest.approx(before[0] - 40 / viewer.view.scale, abs=0.02)


def test_home_shows_the_whole_world_again(viewer):
    before = viewer.view
    viewer.choose_next()
    viewer.zoom(3, (10, 20))
    viewer.pan(100, 100)

    viewer.show_all()

    assert viewer.view == before


def test_pause_and_single_steps(viewer, simulation):
    viewer.advance(0.1)
    viewer.toggle_pause()
    viewer.advance(0.1)
    assert simulation.time == pytest.approx(0.1)

    viewer.single_step()
    viewer.advance(0.1)
    assert simulation.time == pytest.approx(0.105)

    viewer.toggle_pause()
    viewer.advance(0.1)
    assert simulation.time == pytest.approx(0.205)


def test_a_reset_ends_commands_and_trails(viewer, keys, simulation):
    keys.hold(1.0, forwards=1.0)
    viewer.shows_trail = True
    viewer.reset()
    keys.hold(0.5)

    assert simulation.models["diff"].pose == pytest.approx((-4, 0, 0))
    assert simulation.time == pytest.approx(0.5)
    assert viewer.image() == Viewer(simulation, SIZE).image()


def test_the_trail_shows_where_the_robot_was(viewer, keys):
    keys.hold(2.0, forwards=1.0)
    without = np.asarray(viewer.image())
    viewer.shows_trail = True

    changed = np.argwhere((np.asarray(viewer.image()) != without).any(axis=2))

    assert np.ptp(changed[:, 1]) == pytest.approx((1.0 - 0.3) * viewer.view.scale, abs=4)


def test_the_trail_of_odometry_that_drifts_leaves_that_of_the_robot(tmp_path):
    drift = {"translation_per_metre": 0.01, "rotation_per_metre": 0.05}
    drive = {"type": "DiffDrive", "name": "drive", "body": "base", "odom_drift": drift}
    body = {"name": "base", "footprints": [{"type": "circle", "radius": 0.2, "density": 1}]}
    robot = {"bodies": [body], "plugins": [drive]}
    models = [{"name": "robot", "model": robot, "pose": [1, 1, 1]}]
    world = {"properties": {}, "layers": [], "models": models}
    with Simulation(world, seed=1) as simulation:
        trail = Trail(simulation)
        simulation.models["robot"].command(0.5, 0.3)
        for _ in range(100):
            simulation.step(20)
            trail.note("robot", reads_odometry=True)

        true, believed = trail.lines
        assert math.dist(true[0], believed[0]) < 0.2
        assert math.dist(true[-1], believed[-1]) > 0.05


def test_the_status_says_time_rate_pose_and_velocity(viewer, keys):
    keys.hold(1.0, forwards=1.0, turn=1.0)

    world, robot = viewer.status()

    assert world == "1.00 s   1.00 x real time"
    assert robot.startswith("diff   x -3.5")
    assert f"yaw {math.degrees(1):.0f}\N{DEGREE SIGN}   0.50 m/s  1.00 rad/s" in robot
    viewer.toggle_pause()
    assert viewer.status()[0] == "1.00 s   paused"


def test_a_deleted_robot_is_no_trouble(viewer, keys, simulation):
    viewer.choose_next()
    keys.hold(0.2, forwards=1.0)
    simulation.delete("diff")

    keys.hold(0.2, turn=1.0)
    viewer.image()

    assert viewer.status()[1] == ""
    viewer.choose_next()
    assert viewer.chosen == "omni"


def test_a_world_without_models_can_be_looked_at():
    with Simulation({"properties": {}, "layers": []}) as simulation:
        viewer = Viewer(simulation, SIZE)
        viewer.choose_next()
        viewer.choose_at((10, 10))
        Keys(viewer).hold(0.1, forwards=1.0)

        assert viewer.image().size == SIZE
        assert viewer.status()[1] == ""


def test_pictures_are_saved_under_names_of_their_own(viewer, tmp_path):
    viewer.save_picture(tmp_path)
    viewer.save_picture(tmp_path)

    assert sorted(path.name for path in tmp_path.iterdir()) == ["flatland_1.png", "flatland_2.png"]
    assert "saved flatland_2.png" in viewer.status()[0]
    viewer.save_picture(tmp_path / "missing")
    assert "cannot be written" in viewer.message


def test_a_robot_to_follow_must_be_there(simulation):
    viewer = Viewer(simulation, SIZE, follow="omni")
    assert (viewer.chosen, viewer.is_following) == ("omni", True)

    with pytest.raises(FlatlandError, match='no model "omno"'):
        Viewer(simulation, SIZE, follow="omno")
