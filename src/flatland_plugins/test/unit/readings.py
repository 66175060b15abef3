"""Shared readings of tests: odometry, its noise, and the log."""

import math
from typing import Any, Sequence, Tuple

import numpy as np

FILTERED, GROUND_TRUTH, TWIST = "/odometry/filtered", "/odometry/ground_truth", "/twist"


def pose_of(odometry: Any) -> Tuple[float, float, float]:
    """The pose in an Odometry, which is flat on the floor."""
    position, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    assert (q.x, q.y) == (0.0, 0.0)
    return position.x, position.y, 2.0 * math.atan2(q.z, q.w)


def twist_of(stamped: Any) -> Tuple[float, float, float]:
    """The velocity in an Odometry or a TwistWithCovarianceStamped."""
    twist = stamped.twist.twist
    return twist.linear.x, twist.linear.y, twist.angular.z


def assert_white(noise: np.ndarray, variances: Sequence[float]) -> None:
    """Asserts that noise (samples, components) is normal about zero, and uncorrelated."""
    scaled = noise / np.sqrt(variances)
    count = len(scaled)
    # A sum of n squares of standard normals has the mean n and the variance 2 n (chi-squared).
    assert np.abs((scaled**2).sum(axis=0) - count).max() < 4 * math.sqrt(2 * count)
    assert np.abs(scaled.sum(axis=0)).max() < 4 * math.sqrt(count)
    # Components are uncorrelated, and so are consecutive samples.
    correlation = scaled.T @ scaled / count - np.diag((scaled**2).mean(axis=0))
    assert np.abs(correlation).max() < 4 / math.sqrt(count)
    assert np.abs((scaled[1:] * scaled[:-1]).mean(axis=0)).max() < 4 / math.sqrt(count)


def assert_covariance(samples: np.ndarray, covariance: Any) -> None:
    """Asserts that these rows are drawn from the normal distribution of mean 0 and a covariance."""
    count = len(samples)
    white = np.linalg.solve(np.linalg.cholesky(covariance), samples.T).T
    # A sum of n squares of standard normals has the mean n and the variance 2 n (chi-squared), and
    # one of n products of two of them the mean 0 and the variance n.
    products = white.T @ white
    squares = np.diag(products)
    assert np.abs(squares - count).max() < 4 * math.sqrt(2 * count)
    assert np.abs(products - np.diag(squares)).max() < 4 * math.sqrt(count)
    assert np.abs(white.sum(axis=0)).max() < 4 * math.sqrt(count)
