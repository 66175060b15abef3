"""Makes the pictures of the tutorials' worlds, and of a rendering, in docs/images."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from blocks import blocks_of
from page_run import ROOT

from flatland2d import Simulation, messages

IMAGES = ROOT / "docs" / "images"


def render_tutorials() -> None:
    """The pictures of tutorials: their files, rendered as the pages say."""
    page = ROOT / "docs" / "tutorials"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for tutorial, world, options in (
            ("world", "rooms.world", {"sensors": True}),
            ("robot", "world", {"sensors": True}),
            ("own_node", "", {}),
            ("people_and_doors", "people.world", {"names": True}),
        ):
            for block in blocks_of(page / f"{tutorial}.md"):
                if block.file:
                    (folder / block.file).write_text(block.text)
                elif block.language == "python" and tutorial == "world":
                    exec(block.text.replace('"map.png"', f'"{folder}/map.png"'))
                elif "way.png" in block.text:
                    run = [sys.executable, "-c", block.text]
                    subprocess.run(run, cwd=folder, check=True, stdout=subprocess.DEVNULL)
                    shutil.move(folder / "way.png", IMAGES / "tutorial_way.png")
            if world:
                with Simulation(folder / f"{world}.yaml", seed=2) as simulation:
                    if tutorial == "people_and_doors":
                        open_door = messages.get("std_msgs/Bool")(True)
                        simulation.publish("/door/tween_trigger", open_door)
                        simulation.step(700)
                    short = tutorial.partition("_")[0]
                    options["size"] = (720, 220 if short == "people" else 440)
                    simulation.save_picture(IMAGES / f"tutorial_{short}.png", **options)
    with Simulation("office", seed=1) as simulation:
        simulation.models["turtlebot"].command(0.5, 0.2)
        simulation.step(400)
        options = {"size": (900, 500), "follow": "turtlebot", "sensors": True}
        simulation.save_picture(IMAGES / "render.png", **options)


if __name__ == "__main__":
    render_tutorials()
