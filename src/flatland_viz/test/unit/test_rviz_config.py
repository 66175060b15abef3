"""The rviz configuration that is made for a world."""

from copy import deepcopy
from pathlib import Path
from typing import Any, Dict, List

import pytest
import yaml

from flatland_viz.rviz_config import Bounds, for_world

RVIZ = Path(__file__).resolve().parents[2] / "rviz" / "flatland.rviz"
MARKERS = ["/flatland_server/debug/layer/walls", "/flatland_server/debug/model/fleet/robot"]
SCANS = ["/front/scan", "/scan"]
BOUNDS = Bounds(-10.0, -5.0, 30.0, 15.0)


@pytest.fixture
def base() -> Dict[str, Any]:
    """The configuration that flatland_viz starts from."""
    config: Dict[str, Any] = yaml.safe_load(RVIZ.read_text())
    return config


def displays(config: Dict[str, Any], kind: str) -> List[Dict[str, Any]]:
    """The displays of a kind."""
    return [d for d in config["Visualization Manager"]["Displays"] if d["Class"] == kind]


def test_each_topic_of_markers_has_a_display_like_the_pattern(base):
    [pattern, *_] = displays(base, "rviz/MarkerArray")

    shown = displays(for_world(base, MARKERS, SCANS, BOUNDS), "rviz/MarkerArray")

    assert [(d["Name"], d["Marker Topic"]) for d in shown] == [
        ("layer/walls", MARKERS[0]),
        ("model/fleet/robot", MARKERS[1]),
    ]
    for display in shown:
        assert {**display, "Name": "", "Marker Topic": ""} == {
            **pattern,
            "Name": "",
            "Marker Topic": "",
        }


def test_each_topic_of_scans_has_a_display_like_the_pattern(base):
    [pattern, *_] = displays(base, "rviz/LaserScan")

    shown = displays(for_world(base, MARKERS, SCANS, BOUNDS), "rviz/LaserScan")

    assert [(d["Name"], d["Topic"]) for d in shown] == [
        ("front/scan", "/front/scan"),
        ("scan", "/scan"),
    ]
    for display in shown:
        assert {**display, "Name": "", "Topic": ""} == {**pattern, "Name": "", "Topic": ""}


def test_a_world_without_scans_has_no_display_for_them(base):
    config = for_world(base, [], [], BOUNDS)

    assert displays(config, "rviz/LaserScan") == []
    assert displays(config, "rviz/MarkerArray") == []


def test_all_other_displays_stay(base):
    kinds = [d["Class"] for d in base["Visualization Manager"]["Displays"]]
    others = [kind for kind in kinds if kind not in ("rviz/MarkerArray", "rviz/LaserScan")]

    config = for_world(base, MARKERS, SCANS, BOUNDS)

    shown = [d["Class"] for d in config["Visualization Manager"]["Displays"]]
    assert len(others) > 1
    assert shown[: len(others)] == others


@pytest.mark.parametrize(
    "bounds",
    [
        pytest.param(Bounds(-10.0, -1.0, 90.0, 1.0), id="wide"),
        pytest.param(Bounds(-1.0, -10.0, 1.0, 90.0), id="high"),
        pytest.param(Bounds(-30.0, -12.5, 35.0, 12.5), id="the office"),
        pytest.param(Bounds(100.0, 100.0, 100.5, 100.5), id="small and far away"),
    ],
)
def test_the_view_is_framed_on_the_bounds(base, bounds):
    config = for_world(base, MARKERS, SCANS, bounds)

    view, window = config["Visualization Manager"]["Views"]["Current"], config["Window Geometry"]
    assert view["X"] == pytest.approx((bounds.min_x + bounds.max_x) / 2)
    assert view["Y"] == pytest.approx((bounds.min_y + bounds.max_y) / 2)
    # The scale is in pixels a metre. Panels take some of the window, and the rest is well used.
    across = view["Scale"] * (bounds.max_x - bounds.min_x) / window["Width"]
    along = view["Scale"] * (bounds.max_y - bounds.min_y) / window["Height"]
    assert across < 0.8
    assert along < 0.9
    assert across > 0.5 or along > 0.5


@pytest.mark.parametrize("bounds", [Bounds(3.0, 4.0, 3.0, 4.0), Bounds(0.0, 4.0, 6.0, 4.0)])
def test_bounds_without_an_area_leave_the_scale_as_it_was(base, bounds):
    config = for_world(base, MARKERS, SCANS, bounds)

    view = config["Visualization Manager"]["Views"]["Current"]
    assert (view["X"], view["Y"]) == (3.0, 4.0)
    assert view["Scale"] == base["Visualization Manager"]["Views"]["Current"]["Scale"]


def test_the_configuration_it_starts_from_is_not_changed(base):
    before = deepcopy(base)

    config = for_world(base, MARKERS, SCANS, BOUNDS)
    config["Visualization Manager"]["Displays"][-1]["Name"] = "changed afterwards"
    config["Window Geometry"]["Width"] = 1

    assert base == before
