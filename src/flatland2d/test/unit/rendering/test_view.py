"""The part of the world that a picture shows."""

import math

import pytest

from flatland2d.rendering.view import View, fitting_size
from flatland_server.exceptions import FlatlandError


def test_x_is_to_the_right_and_y_upwards():
    view = View.around((0, 0), 10.0, (200, 100))

    assert view.pixels([(0, 0), (5, 0), (0, 4)]).tolist() == [[100, 50], [150, 50], [100, 10]]


def test_positions_are_the_inverse_of_pixels():
    view = View.around((3.2, -1.7), 37.0, (320, 200))

    assert view.position(tuple(view.pixels([(2.5, 0.5)])[0])) == pytest.approx((2.5, 0.5))
    assert view.center == pytest.approx((3.2, -1.7), abs=0.5 / 37.0)


def test_an_area_fits_with_a_margin():
    view = View.of((-2, -1), (8, 4), (400, 400))

    left, right, bottom, top = view.extent
    assert left == pytest.approx(-2.26, abs=0.05)
    assert right == pytest.approx(8.26, abs=0.05)
    assert bottom < -1 < 4 < top


def test_the_size_that_fits_has_the_shape_of_the_area():
    assert fitting_size((0, 0), (20, 10), 1600) == (1600, 840)


@pytest.mark.parametrize("low", [(1.0, 1.0), (math.nan, 0.0), (-math.inf, 0.0)])
def test_an_area_without_extent_shows_its_surroundings(low):
    left, right, bottom, top = View.of(low, (1.0, 1.0), (100, 100)).extent

    assert 2.0 <= right - left < 3.0
    assert 2.0 <= top - bottom < 3.0


def test_the_scale_ends_before_numbers_get_too_large():
    assert View.around((1, 2), 1e-9, (300, 200)).scale == 0.01
    assert View.around((1, 2), 1e9, (300, 200)).scale == 1e4


@pytest.mark.parametrize("size", [(0, 10), (10, 16385), (3.5, 4), (3,), "big", 7, (math.nan, 3)])
def test_a_size_that_no_picture_can_have_is_refused(size):
    with pytest.raises(FlatlandError, match="expected a width and a height of 1 to 16384 pixels"):
        View.around((0, 0), 1.0, size)
