"""Simplified outlines have fewer segments; they and the original are within the tolerance."""

import math

import numpy as np
import pytest
from PIL import Image, ImageDraw

from flatland_server.maps.simplify_outlines import TOLERANCES, simplify
from flatland_server.maps.wall_outlines import outlines


def picture(draw_on, size: int = 120) -> np.ndarray:
    """The bright pixels of a drawing in black on white."""
    image = Image.new("1", (size, size), 1)
    draw_on(ImageDraw.Draw(image))
    return np.asarray(image)


def corners(segments: np.ndarray) -> set:
    return set(map(tuple, segments.reshape(-1, 2).tolist()))


def directionless(segments: np.ndarray) -> list:
    return sorted(sorted([(a, b), (c, d)]) for a, b, c, d in segments.tolist())


def farthest(points: np.ndarray, segments: np.ndarray) -> float:
    """The largest distance of any point to the nearest of some segments."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    to_points = points[:, None, :] - start
    share = np.clip((to_points * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    return float(np.hypot(*np.moveaxis(to_points - share[..., None] * along, -1, 0)).min(1).max())


DRAWINGS = {
    "a thick diagonal": lambda draw: draw.line([10, 15, 105, 80], fill=0, width=4),
    "a thin diagonal": lambda draw: draw.line([10, 15, 105, 80], fill=0),
    "a steep diagonal": lambda draw: draw.line([50, 5, 57, 110], fill=0, width=3),
    "a disc": lambda draw: draw.ellipse([20, 20, 100, 100], fill=0),
    "a ring": lambda draw: draw.ellipse([20, 20, 100, 100], outline=0, width=3),
    "a triangle": lambda draw: draw.polygon([(10, 10), (110, 40), (50, 110)], fill=0),
}


@pytest.mark.parametrize("level", [1, 2])
@pytest.mark.parametrize("name", DRAWINGS)
def test_an_outline_gets_fewer_segments_within_the_tolerance(name, level):
    original = outlines(picture(DRAWINGS[name]))
    # Outlines of pixels that touch only at corners cross there, and cannot be simplified as much.
    share = 1.0 if name == "a thin diagonal" else 1 / 3

    simplified, deviation = simplify(original, TOLERANCES[level])

    assert len(simplified) < len(original) * share
    assert farthest(original.reshape(-1, 2), simplified) <= TOLERANCES[level] + 1e-9
    dense = np.concatenate(
        [simplified[:, :2] * (1 - t) + simplified[:, 2:] * t for t in np.linspace(0, 1, 21)]
    )
    assert farthest(dense, original) <= TOLERANCES[level] + 1e-9
    measured = max(farthest(original.reshape(-1, 2), simplified), farthest(dense, original))
    assert measured <= deviation + 1e-9
    if name != "a thin diagonal":  # its outlines cross, and come close to each other
        assert deviation == pytest.approx(measured)
    assert corners(simplified) <= corners(original)


@pytest.mark.parametrize("drawing", DRAWINGS.values(), ids=DRAWINGS.keys())
def test_a_closed_outline_stays_closed_with_fewer_segments_at_each_level(drawing):
    original = outlines(picture(drawing))

    least, simplified, most = (simplify(original, each).segments for each in (2.0, 1.0, 0.0))

    ends, counts = np.unique(simplified.reshape(-1, 2), axis=0, return_counts=True)
    assert (counts % 2 == 0).all(), ends[counts % 2 == 1]
    assert len(least) <= len(simplified) <= len(most)
    assert directionless(most) == directionless(original)


@pytest.mark.parametrize("tolerance", [0.0, 1.0, 2.0])
def test_the_corners_of_a_rectangle_stay_exactly(tolerance):
    original = outlines(picture(lambda draw: draw.rectangle([20, 30, 79, 89], fill=0)))

    simplified = simplify(original, tolerance).segments

    assert corners(simplified) == {(20.0, 30.0), (80.0, 30.0), (80.0, 90.0), (20.0, 90.0)}
    assert len(simplified) == 4


def test_a_corner_at_which_two_blocks_touch_is_kept():
    def checkerboard(draw):
        draw.rectangle([20, 20, 49, 49], fill=0)
        draw.rectangle([50, 50, 79, 79], fill=0)

    simplified = simplify(outlines(picture(checkerboard)), 2.0).segments

    assert farthest(np.array([[50.0, 70.0]]), simplified) == 0.0


def test_a_junction_of_three_lines_is_kept():
    lines = np.array([[0, 0, 50, 0.5], [50, 0.5, 100, 0], [50, 0.5, 50, 80]], dtype=float)

    simplified = simplify(lines, 2.0).segments

    assert (50.0, 0.5) in corners(simplified)
    assert len(simplified) == 3


def test_the_ends_of_an_open_line_are_kept():
    points = [(float(i), float(i % 2)) for i in range(20)]
    line = np.array([(*a, *b) for a, b in zip(points, points[1:])])

    simplified = simplify(line, 1.0).segments

    assert directionless(simplified) == [[(0.0, 0.0), (19.0, 1.0)]]
    assert simplify(np.empty((0, 4)), 1.0).segments.shape == (0, 4)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_wall_of_one_pixel_does_not_vanish(level):
    original = outlines(picture(lambda draw: draw.point([(60, 60)], fill=0)))

    assert len(simplify(original, TOLERANCES[level]).segments) > 0


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_thin_ring_has_no_gap(level):
    ring = picture(lambda draw: draw.ellipse([20, 20, 100, 100], outline=0))
    segments = simplify(outlines(ring), TOLERANCES[level]).segments
    middle = np.array([60.5, 59.5])

    start, along = segments[:, :2] - middle, segments[:, 2:] - segments[:, :2]
    for angle in np.linspace(0.001, math.tau, 2000):
        ray = np.array([math.cos(angle), math.sin(angle)])
        across = ray[0] * along[:, 1] - ray[1] * along[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / across
            share = (start[:, 0] * ray[1] - start[:, 1] * ray[0]) / across
        assert ((distance > 0) & (share >= -1e-9) & (share <= 1 + 1e-9)).any(), angle


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_world_is_simplified_by_its_level(good_files, level):
    image = Image.new("L", (200, 200), 255)
    ImageDraw.Draw(image).ellipse([20, 20, 180, 180], fill=0)
    image.save(good_files.folder / "map.png")
    exact = good_files.load().layers[0].segments

    segments = good_files.load(simplify_map=level).layers[0].segments

    if level == 0:
        assert np.array_equal(segments, exact)
    else:
        assert len(segments) < len(exact) / 4
        # In metres: pixels of 5 cm.
        assert farthest(exact.reshape(-1, 2), segments) <= TOLERANCES[level] * 0.05 + 1e-9


def test_line_segments_are_never_simplified(good_files):
    points = [(i, math.sin(i) / 10) for i in range(30)]
    lines = [f"{a} {b} {c} {d}" for (a, b), (c, d) in zip(points, points[1:])]
    good_files.write("lines.dat", "\n".join(lines))

    assert len(good_files.load(simplify_map=2).layers[1].segments) == 29
