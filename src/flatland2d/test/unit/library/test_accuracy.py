"""The accuracy of the physics, as docs/reference/model.md tells it."""

import math

import pytest

from flatland2d import Simulation

BOX = {"type": "polygon", "points": [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]}
CIRCLE = {"type": "circle", "radius": 0.2}
ROD = {"type": "polygon", "points": [[0, -0.02], [1, -0.02], [1, 0.02], [0, 0.02]]}
FIXED = {"name": "fixed", "type": "static", "footprints": [{**CIRCLE, "density": 0, "layers": []}]}

pytestmark = pytest.mark.parametrize(
    ("step_size", "iterations"), [(0.005, 10), (0.005, 100), (0.001, 10)]
)


def load(*bodies, joints=(), step_size, iterations):
    """A simulation of one model, and its last body."""
    properties = dict.fromkeys(("velocity_iterations", "position_iterations"), iterations)
    model = {"bodies": list(bodies), "joints": list(joints)}
    content = {"properties": properties, "layers": [], "models": [{"name": "it", "model": model}]}
    sim = Simulation(content, step_size=step_size)
    return sim, sim.models["it"].model.bodies[bodies[-1]["name"]].physics_body


@pytest.mark.parametrize(("speed", "loss"), [(1.0, 0.018), (4.0, 0.21)])
def test_a_hinge_loses_speed_with_step_size_and_speed_squared(speed, loss, step_size, iterations):
    anchors = [{"name": name, "anchor": [0, 0]} for name in ("fixed", "rod")]
    hinge = {"type": "revolute", "name": "hinge", "bodies": anchors}
    rod = {"name": "rod", "footprints": [{**ROD, "density": 10, "layers": []}]}
    sim, body = load(FIXED, rod, joints=[hinge], step_size=step_size, iterations=iterations)
    body.velocity = (0.0, 0.0, speed)

    sim.step(round(10.0 / step_size))

    expected = speed / math.sqrt(1.0 + 0.75 * speed**2 * step_size * 10.0)
    assert body.velocity[2] == pytest.approx(expected, rel=3e-3)
    if step_size == 0.005:
        assert 1.0 - body.velocity[2] / speed == pytest.approx(loss, abs=0.002)


def test_damping_is_less_than_exponential_by_the_step(step_size, iterations):
    disc = {"name": "disc", "linear_damping": 1.0, "footprints": [{**CIRCLE, "density": 10}]}
    sim, body = load(disc, step_size=step_size, iterations=iterations)
    body.velocity = (1.0, 0.0, 0.0)

    sim.step(round(1.0 / step_size))

    error = body.velocity[0] / math.exp(-1.0) - 1.0
    assert error == pytest.approx(0.5 * step_size, rel=0.1)


@pytest.mark.parametrize(
    ("post", "shape", "least", "most"),
    [(BOX, BOX, 0.0145, 0.0205), (BOX, CIRCLE, 0.0045, 0.0105), (CIRCLE, CIRCLE, -0.0055, 0.0005)],
)
def test_polygons_in_contact_keep_a_distance_and_circles_overlap(
    post, shape, least, most, step_size, iterations
):
    bodies = [
        {"name": "post", "type": "static", "footprints": [{**post, "density": 30}]},
        {"name": "it", "pose": [0.5, 0, 0], "footprints": [{**shape, "density": 30}]},
    ]
    sim, body = load(*bodies, step_size=step_size, iterations=iterations)

    for _ in range(round(2.0 / step_size)):
        body.apply_force((-20.0, 0.0))
        sim.step()

    assert least < body.pose[0] - 0.4 < most
