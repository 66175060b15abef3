"""An rviz configuration of a user, with MarkerArray displays only."""

import numpy as np
import pytest
import yaml
from screen_pictures import near

pytestmark = pytest.mark.slow

BACKGROUND = [10, 20, 60]
COLORS = {  # of the world's files, and the least number of pixels
    "layer/map": ((102, 102, 102), 3000),
    "model/turtlebot": ((51, 128, 204), 20),
    "model/box_1": ((194, 145, 87), 80),
}


def config(frame_rate):
    displays = [
        {
            "Class": "rviz/MarkerArray",
            "Name": topic,
            "Enabled": True,
            "Value": True,
            "Marker Topic": f"/flatland_server/debug/{topic}",
        }
        for topic in COLORS
    ]
    return {
        "Visualization Manager": {
            "Global Options": {
                "Fixed Frame": "map",
                "Frame Rate": frame_rate,
                "Background Color": "; ".join(map(str, BACKGROUND)),
            },
            "Displays": displays,
            "Tools": [{"Class": "rviz/Interact"}],
            "Views": {
                "Current": {"Class": "rviz/TopDownOrtho", "X": 2.5, "Y": 0, "Scale": 20, "Angle": 0}
            },
        },
        "Window Geometry": {"Width": 1390, "Height": 890, "X": 0, "Y": 0},
    }


def test_markers_alone_show_the_world(screen, ros, office, waiting, tmp_path):
    file = tmp_path / "generic.rviz"
    file.write_text(yaml.safe_dump(config(ros.frame_rate)))
    ros.launch_server(office / "world.yaml", "use_rviz:=true")
    ros.start("rviz", "-d", file)
    screen.wait_for_window(".*generic.rviz.* - RViz")

    def missing():
        pixels = screen.picture("generic_rviz")
        ys, xs = np.nonzero(near(pixels, BACKGROUND, 0))
        if not len(ys):
            return list(COLORS)
        view = pixels[ys.min() : ys.max(), xs.min() : xs.max()]
        return [
            topic for topic, (color, least) in COLORS.items() if near(view, color, 40).sum() < least
        ]

    waiting(lambda: not missing(), "walls, robot and box")
