"""What docs/files.md says is so: each of its YAML blocks loads, together they are a world."""

import re
from pathlib import Path

import pytest
from PIL import Image

from flatland_server.check_world import AnyLayer
from flatland_server.model import ModelConfig
from flatland_server.world import World

PAGE = Path(__file__).resolve().parents[3] / "docs" / "files.md"
BLOCK = re.compile(r"```yaml\n# file: (\S+)\n(.*?)```", re.DOTALL)


@pytest.fixture
def folder(tmp_path):
    """The page's files, and those that they name."""
    for name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    Image.new("L", (200, 200), 0).save(tmp_path / "map.png")
    (tmp_path / "lines.dat").write_text("-5 0 5 0\n")
    footprint = "{type: circle, radius: 0.1, density: 1}"
    (tmp_path / "bodies.yaml").write_text(
        f"{{name: base_link, footprints: [{footprint}]}}\n---\n"
        f"{{name: arm, footprints: [{footprint}]}}\n"
    )
    (tmp_path / "tower_footprints.yaml").write_text(f"[{footprint}]\n")
    return tmp_path


def test_every_yaml_block_is_one_of_the_files():
    text = PAGE.read_text(encoding="utf-8")
    assert len(BLOCK.findall(text)) == text.count("```yaml")


def test_the_world_of_the_page_loads(folder):
    world = World.from_file(folder / "world.yaml")

    assert [layer.name for layer in world.layers] == ["map", "walls_3d", "reflectance"]
    assert [len(layer.segments) for layer in world.layers] == [4, 1, 0]
    assert list(world.models["robot1"].bodies) == ["base_link", "caster"]
    assert world.plugin_count == 2


def test_the_parametric_model_of_the_page_loads(folder, monkeypatch):
    monkeypatch.setenv("SLOW", "true")
    model = ModelConfig.from_file(folder / "parametric.model.yaml", AnyLayer())

    assert [body.name for body in model.bodies] == ["base_link", "arm"]
    limits = model.plugins[0].reader.get_section("linear_dynamics")
    assert limits.get_float("velocity_limit") == 0.75
    assert limits.get_float("acceleration_limit") == 0.5
