"""The rviz configurations of the window and of displays."""

from copy import deepcopy
from pathlib import Path
from typing import Any, Dict, List

import pytest
import yaml

from flatland_viz.rviz_config import for_window

RVIZ = Path(__file__).resolve().parents[2] / "rviz" / "flatland.rviz"


@pytest.fixture
def base() -> Dict[str, Any]:
    """The configuration that flatland_viz starts from."""
    config: Dict[str, Any] = yaml.safe_load(RVIZ.read_text())
    return config


def displays(config: Dict[str, Any]) -> List[Dict[str, Any]]:
    """All displays."""
    shown: List[Dict[str, Any]] = config["Visualization Manager"]["Displays"]
    return shown


def tools(config: Dict[str, Any]) -> List[str]:
    """The classes of the tools."""
    return [tool["Class"] for tool in config["Visualization Manager"]["Tools"]]


def test_the_window_starts_without_displays_of_a_world(base):
    kinds = [display["Class"] for display in displays(for_window(base, 30))]

    assert kinds == ["rviz/Grid", "rviz/TF", "flatland_viz/Models"]


def test_the_window_looks_from_above(base):
    manager = for_window(base, 30)["Visualization Manager"]

    assert manager["Views"]["Current"]["Class"] == "flatland_viz/MapView"
    assert manager["Global Options"] == base["Visualization Manager"]["Global Options"]


def test_the_window_draws_as_often_as_it_is_told(base):
    options = for_window(base, 12)["Visualization Manager"]["Global Options"]

    assert options == {**base["Visualization Manager"]["Global Options"], "Frame Rate": 12}


def test_the_window_has_tools_for_the_world(base):
    assert tools(for_window(base, 30)) == [
        "flatland_viz/Interact",
        "flatland_viz/Measure",
        "flatland_viz/SpawnModel",
        "flatland_viz/PauseSim",
    ]


def test_the_window_places_itself(base):
    assert "Window Geometry" in base
    assert "Window Geometry" not in for_window(base, 30)


def test_the_configuration_it_starts_from_is_not_changed(base):
    before = deepcopy(base)

    for_window(base, 30)["Visualization Manager"]["Tools"][0]["Class"] = "changed afterwards"

    assert base == before
