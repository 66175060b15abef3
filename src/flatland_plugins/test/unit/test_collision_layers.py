"""The layers of footprints: collisions of a robot with walls."""

import pytest

DRIVE = "type: DiffDrive, name: drive, body: base"


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

    disc = f"{{type: circle, radius: 0.2, density: 10, {footprint}}}"

    robot = files.robot(DRIVE, footprint=disc, layers=layers).drive(1.0).run(4.0)

    assert robot.model().pose.x == pytest.approx(1.8 if stops else 4.0, abs=0.02)
