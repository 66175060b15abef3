"""The office's robot with the errors and limits of a real one."""

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
    assert [plugin.name for plugin in real.config.plugins] == [
        plugin.name for plugin in perfect.config.plugins
    ]


def test_it_drives_within_its_limits(office_with_it, caplog):
    office_with_it.drive(5.0, topic="/real/cmd_vel").run(0.1)
    velocity = office_with_it.last("/real/odometry/ground_truth").twist.twist.linear.x
    assert velocity == pytest.approx(0.1, abs=0.04)  # 1 m/s^2

    office_with_it.run(0.5)
    assert twist_of(office_with_it.last("/real/odometry/ground_truth")) == pytest.approx(
        (0.26, 0.0, 0.0), abs=1e-3
    )
    office_with_it.drive(0.0, -5.0, topic="/real/cmd_vel").run(1.5)
    assert twist_of(office_with_it.last("/real/odometry/ground_truth")) == pytest.approx(
        (0.0, 0.0, -1.82), abs=1e-3
    )
    assert warnings(caplog) == []


def test_its_odometry_drifts_as_it_drives_and_not_as_it_stands(office_with_it):
    office_with_it.drive(0.2, 0.4, topic="/real/cmd_vel").run(20.0)
    office_with_it.drive(0.0, topic="/real/cmd_vel").run(1.0)

    estimated = office_with_it.last("/real/odometry/filtered")
    truth = office_with_it.last("/real/odometry/ground_truth")
    error = np.subtract(pose_of(estimated), pose_of(truth))
    # After 4 m and 8 rad: 3 cm and 5 degrees (standard deviations), and what the heading bends.
    assert 1e-3 < np.hypot(*error[:2]) < 0.4
    assert office_with_it.run(10.0).last("/real/odometry/filtered").pose == estimated.pose
    assert estimated.header.frame_id == "real_odom"


def test_its_messages_say_how_far_off_they_may_be(office_with_it):
    odometry, twist = (
        office_with_it.run(0.1).last(f"/real/{topic}") for topic in ("odometry/filtered", "twist")
    )

    for covariance in (odometry.pose.covariance, odometry.twist.covariance):
        matrix = np.reshape(covariance, (6, 6))
        assert (np.linalg.eigvalsh(matrix) > 0.0).all()  # as filters require
    assert list(twist.twist.covariance) == list(odometry.twist.covariance)
    assert twist_of(twist)[0] != 0.0


def test_its_scan_is_that_of_a_small_lidar(office_with_it):
    scan = office_with_it.run(0.25).last("/real/scan")

    ranges = np.asarray(scan.ranges)
    assert len(ranges) == 360
    assert scan.range_max == pytest.approx(3.5)
    assert ranges[np.isfinite(ranges)].max() <= np.float32(3.5)
    assert np.isfinite(ranges).any()
    assert len(scan.intensities) == 0
