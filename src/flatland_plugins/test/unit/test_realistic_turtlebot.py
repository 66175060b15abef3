"""The office's robot with the errors and limits of a real one."""

import math
from pathlib import Path

import numpy as np
import pytest
from logged import warnings
from readings import pose_of, twist_of

from flatland2d.cli import main
from flatland_server.geometry import Pose
from flatland_server.testing import Harness

OFFICE = Path(__file__).resolve().parents[3] / "flatland_server" / "worlds" / "office"
MODEL = OFFICE / "turtlebot_realistic.model.yaml"
ODOMETRY, IMU = "/real/wheel_odom", "/real/imu/data"
START = Pose(-2.0, -1.5, 0.0)  # in the lobby


@pytest.fixture
def office_with_it(office) -> Harness:
    """The office with this robot in it, in the namespace "real"."""
    office.world.spawn_model(MODEL, "real", "real", START)
    return office


def test_flatland_check_finds_no_fault_in_it():
    assert main(["check", str(MODEL)]) == 0


def test_its_body_is_that_of_the_perfect_one(office_with_it):
    real, perfect = (office_with_it.model(name) for name in ("real", "turtlebot"))

    assert real.config.bodies == perfect.config.bodies
    plugins = ({each.name for each in model.config.plugins} for model in (real, perfect))
    assert next(plugins) == next(plugins) | {"imu", "gps"}


def test_it_drives_within_its_limits(office_with_it, caplog):
    speeds = []
    for command, seconds in (((5.0,), 0.1), ((5.0,), 0.5), ((0.0, -5.0), 1.5)):
        office_with_it.drive(*command, topic="/real/cmd_vel").run(seconds)
        speeds.append(twist_of(office_with_it.last("/real/odometry/ground_truth")))

    assert speeds[0][0] == pytest.approx(0.1, abs=0.04)  # 1 m/s^2
    assert speeds[1] == pytest.approx((0.26, 0.0, 0.0), abs=1e-3)
    assert speeds[2] == pytest.approx((0.0, 0.0, -1.82), abs=1e-3)
    assert warnings(caplog) == []


def test_its_odometry_drifts_as_it_drives_and_not_as_it_stands(office_with_it):
    office_with_it.drive(0.2, 0.4, topic="/real/cmd_vel").run(20.0)
    office_with_it.drive(0.0, topic="/real/cmd_vel").run(1.0)

    estimated = office_with_it.last(ODOMETRY)
    truth = office_with_it.last("/real/odometry/ground_truth")
    error = np.subtract(pose_of(estimated), pose_of(truth))
    # After 4 m and 8 rad: 3 cm and 5 degrees (standard deviations), and what the heading bends.
    assert 1e-3 < np.hypot(*error[:2]) < 0.4
    assert office_with_it.run(10.0).last(ODOMETRY).pose == estimated.pose
    assert estimated.header.frame_id == "real_odom"


def test_its_messages_say_how_far_off_they_may_be(office_with_it):
    odometry = office_with_it.run(0.1).last(ODOMETRY)
    twist = office_with_it.last("/real/twist")

    for covariance in (odometry.pose.covariance, odometry.twist.covariance):
        matrix = np.reshape(covariance, (6, 6))
        assert (np.linalg.eigvalsh(matrix) > 0.0).all()  # as filters require
    assert list(twist.twist.covariance) == list(odometry.twist.covariance)


def test_its_twist_covariance_equals_its_errors_at_full_speed(office_with_it):
    office_with_it.drive(0.26, 1.82, topic="/real/cmd_vel").run(5.0)

    messages = office_with_it.record(ODOMETRY, 30.0)

    errors = np.array([twist_of(message) for message in messages])
    published = np.diag(np.reshape(messages[0].twist.covariance, (6, 6)))
    assert errors.var(axis=0)[[0, 2]] == pytest.approx(published[[0, 5]], rel=0.25)


@pytest.mark.slow
def test_a_filter_drifts_less_with_the_gyroscope(files):
    """Headings of fifteen robots, 8 m and 12 rad on: by odometry, its twist, and twist and IMU."""
    disc = "{type: circle, radius: 0.18, density: 38, layers: []}"  # which meets nothing
    bodies = f"bodies: [{{name: base_link, footprints: [{disc}]}}]"
    text = MODEL.read_text().replace("<<: $include turtlebot.model.yaml", bodies)
    # Rates that divide that of the steps, and no lidar.
    text = text.replace("pub_rate: 30", "pub_rate: 20").replace("pub_rate: 100", "pub_rate: 20")
    files.write("real.model.yaml", text[: text.index("  - type: Laser")])
    names = [f"r{i}" for i in range(15)]
    run = files.load_models({name: f"model: real.model.yaml, namespace: {name}" for name in names})
    for name in names:
        run.drive(0.2, 0.3, topic=f"/{name}/cmd_vel")
    headings = np.zeros((2, 15))  # of the twist, and of both
    for _ in range(800):
        run.run(0.05)
        wheels = [run.last(f"/{name}/wheel_odom") for name in names]
        imus = [run.last(f"/{name}/imu/data") for name in names]
        by_wheels = [odometry.twist.twist.angular.z for odometry in wheels]
        rates = np.array([by_wheels, [imu.angular_velocity.z for imu in imus]])
        # A Kalman filter of rates: the mean, weighted by their inverse variances.
        variances = wheels[0].twist.covariance[35], imus[0].angular_velocity_covariance[8]
        both = np.average(rates, axis=0, weights=np.reciprocal(variances))
        headings += 0.05 * np.array([rates[0], both])

    truths = [pose_of(run.last(f"/{name}/odometry/ground_truth"))[2] for name in names]
    estimates = np.array([[pose_of(odometry)[2] for odometry in wheels], *headings])
    errors = np.remainder(estimates - truths + math.pi, math.tau) - math.pi
    pose, _, fused = np.sqrt((errors**2).mean(axis=1))
    # Variances of 8 m and 12 rad: slip, radius and track width, curvature.
    expected = 1.2e-4 * 8 + 9.3e-5 * 12 + (0.002**2 + 0.0015**2) * 12**2 + (0.008 * 8) ** 2
    assert errors[1] == pytest.approx(errors[0], abs=1e-3)
    assert math.sqrt(expected) / 2 < pose < math.sqrt(expected) * 2
    assert fused < pose / 3


def test_its_scan_is_that_of_a_small_lidar(office_with_it):
    scan = office_with_it.run(0.25).last("/real/scan")

    ranges = np.asarray(scan.ranges)
    assert len(ranges) == 360
    assert scan.range_max == pytest.approx(3.5)
    assert ranges[np.isfinite(ranges)].max() <= np.float32(3.5)
    assert np.isfinite(ranges).any()
    assert len(scan.intensities) == 0
