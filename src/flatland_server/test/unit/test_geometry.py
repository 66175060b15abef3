"""Poses and quaternions, against rotation matrices; trigonometry of arrays."""

import math

import numpy as np
import pytest
from array_gaps import watch_gaps
from hypothesis import given
from hypothesis import strategies as st

from flatland_server import cos_sin, fill_pose, headings, messages, yaw_of
from flatland_server.geometry import Pose, quaternion, wrap_angle

COORDINATES = st.floats(-100.0, 100.0)
ANGLES = st.floats(-20.0, 20.0)
POSES = st.builds(Pose, COORDINATES, COORDINATES, ANGLES)


def matrix(pose: Pose) -> np.ndarray:
    """A pose as a homogeneous 3 x 3 matrix."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return np.array([[cos, -sin, pose.x], [sin, cos, pose.y], [0.0, 0.0, 1.0]])


@given(POSES, POSES)
def test_composing_poses_multiplies_their_matrices(outer, inner):
    assert matrix(outer.compose(inner)) == pytest.approx(matrix(outer) @ matrix(inner), abs=1e-9)


@given(POSES)
def test_the_inverse_undoes_a_pose(pose):
    assert matrix(pose.inverse()) == pytest.approx(np.linalg.inv(matrix(pose)), abs=1e-9)


@given(ANGLES)
def test_a_wrapped_angle_is_the_same_direction_within_pi(angle):
    wrapped = wrap_angle(angle)

    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize("kind", [Pose, lambda *pose: pose], ids=["Pose", "of a physics body"])
@given(yaw=ANGLES)
def test_the_yaw_of_a_quaternion_is_that_of_its_pose(kind, yaw):
    pose = messages.get("geometry_msgs/Pose")()
    fill_pose(pose, kind(1.0, 2.0, yaw))

    assert (pose.position.x, pose.position.y) == (1.0, 2.0)
    assert math.sin(yaw_of(pose.orientation) - yaw) == pytest.approx(0.0, abs=1e-9)
    assert math.cos(yaw_of(pose.orientation) - yaw) == pytest.approx(1.0)


@pytest.mark.parametrize("roll", [0.0, math.pi])
@given(yaw=ANGLES)
def test_a_quaternion_rolls_about_x_and_then_turns_about_z(yaw, roll):
    x, y, z, w = quaternion(yaw, roll)

    # The rotation matrix of a unit quaternion, against Rz(yaw) Rx(roll).
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    about_z = matrix(Pose(0.0, 0.0, yaw))
    cos, sin = math.cos(roll), math.sin(roll)
    about_x = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
    assert rotation == pytest.approx(about_z @ about_x, abs=1e-9)


# Arrays: the same bits wherever they lie in memory.


def test_cosines_and_sines_of_a_column(monkeypatch):
    poses = np.random.default_rng(1).normal(size=(5, 3))
    gaps = watch_gaps(monkeypatch)

    cosines, sines = cos_sin(poses[:, 2])

    assert cosines == pytest.approx([math.cos(yaw) for yaw in poses[:, 2]])
    assert sines == pytest.approx([math.sin(yaw) for yaw in poses[:, 2]])
    assert gaps == []


def test_headings_of_vectors(monkeypatch):
    vectors = np.array([[[1.0, 0.0], [0.0, 2.0]], [[-1.0, -1.0], [0.0, 0.0]]])
    gaps = watch_gaps(monkeypatch)

    assert headings(vectors) == pytest.approx(
        np.array([[0.0, math.pi / 2], [-0.75 * math.pi, 0.0]])
    )
    assert headings(np.zeros((0, 2))).shape == (0,)
    assert gaps == []
