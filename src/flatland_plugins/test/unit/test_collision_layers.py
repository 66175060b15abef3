"""The layers of footprints: collisions of a robot with walls and with other models."""

from typing import Dict, Tuple

import pytest

DRIVE = "type: DiffDrive, name: drive, body: base"


def drive_ahead(files, footprint: str, layers: Tuple[str, ...], others: Dict[str, str]) -> float:
    """The distance [m] that a robot of 0.2 m covers in 4 s at 1 m/s."""
    disc = f"{{type: circle, radius: 0.2, density: 10, {footprint}}}"
    robot = files.robot(DRIVE, footprint=disc, layers=layers, others=others)
    return float(robot.drive(1.0).run(4.0).model().pose.x)


@pytest.mark.parametrize(
    ("footprint", "stops"),
    [
        pytest.param("friction: 0", True, id="all layers by default"),
        pytest.param("layers: all", True, id="all layers"),
        pytest.param("layers: [walls]", True, id="the layer's"),
        pytest.param("layers: walls", True, id="the layer's, as a text"),
        pytest.param("layers: [bricks]", True, id="the layer's by its second name"),
        pytest.param("layers: [other, walls]", True, id="the layer's and another"),
        pytest.param("layers: [other]", False, id="another"),
        pytest.param("layers: []", False, id="none"),
        pytest.param("collision: false", False, id="collision switched off"),
        pytest.param("sensor: true", False, id="a sensor"),
    ],
)
def test_a_wall_stops_the_footprints_of_its_layers(files, footprint, stops):
    layers = (f"name: [walls, bricks], map: {files.walls('wall', '2 -3 2 3')}", "name: other")

    x = drive_ahead(files, footprint, layers, {})

    assert x == pytest.approx(1.8 if stops else 4.0, abs=0.02)


@pytest.mark.parametrize(
    ("mine", "others", "stops"),
    [
        pytest.param("friction: 0", "friction: 0", True, id="all and all"),
        pytest.param("layers: [a]", "friction: 0", True, id="one and all"),
        pytest.param("layers: [a, b]", "layers: [b, c]", True, id="one shared"),
        pytest.param("layers: [a]", "layers: [b]", False, id="none shared"),
        pytest.param("friction: 0", "layers: []", False, id="all and none"),
        pytest.param("layers: []", "layers: []", False, id="none and none"),
        pytest.param("friction: 0", "collision: false", False, id="its collision switched off"),
        pytest.param("collision: false", "friction: 0", False, id="my collision switched off"),
        pytest.param("friction: 0", "sensor: true", False, id="a sensor"),
    ],
)
def test_a_body_stops_the_footprints_that_share_a_layer(files, mine, others, stops):
    post = f"{{type: circle, radius: 0.2, density: 1, {others}}}"
    model = files.model("post", footprint=post, body="type: static,")
    layers = ("name: a", "name: b", "name: c")

    x = drive_ahead(files, mine, layers, {"post": f"model: {model}, pose: [2, 0, 0]"})

    assert x == pytest.approx(1.6 if stops else 4.0, abs=0.02)
