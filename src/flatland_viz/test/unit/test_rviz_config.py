"""The rviz configurations of the window and of displays."""

from copy import deepcopy
from pathlib import Path

import yaml

from flatland_viz.rviz_config import for_window

RVIZ = Path(__file__).resolve().parents[2] / "rviz" / "flatland.rviz"


def test_the_window_has_tools_and_a_view_from_above_and_no_displays_of_a_world():
    base = yaml.safe_load(RVIZ.read_text())
    before = deepcopy(base)

    config = for_window(base, 12)

    manager = config["Visualization Manager"]
    kinds = [[each["Class"] for each in manager[key]] for key in ("Displays", "Tools")]
    assert kinds[0] == ["rviz/Grid", "rviz/TF", "flatland_viz/Models"]
    tools = ("Interact", "Measure", "SpawnModel", "PauseSim")
    assert kinds[1] == [f"flatland_viz/{tool}" for tool in tools]
    assert manager["Views"]["Current"]["Class"] == "flatland_viz/MapView"
    options = before["Visualization Manager"]["Global Options"]
    assert manager["Global Options"] == {**options, "Frame Rate": 12}
    assert "Window Geometry" in base  # the window places itself
    assert "Window Geometry" not in config
    manager["Tools"][0]["Class"] = "changed afterwards"
    assert base == before
