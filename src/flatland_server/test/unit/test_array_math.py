"""Trigonometry of arrays: the same bits wherever they lie in memory."""

import math

import numpy as np
import pytest
from array_gaps import watch_gaps

from flatland_server import cos_sin, headings


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
