"""Pictures of a world: their content, which does not depend on earlier pictures."""

import io
import logging
import sys
import xml.etree.ElementTree as ElementTree
from unittest.mock import Mock

import numpy as np
import pytest
from PIL import Image

from flatland2d import Simulation
from flatland2d.rendering import renderer as rendering
from flatland2d.rendering.renderer import Renderer, to_array
from flatland2d.rendering.scene import grid_cell
from flatland_server.exceptions import FlatlandError, ModelError
from flatland_server.geometry import Pose
from flatland_server.models.footprint import Circle
from flatland_server.plugins.model_plugin import ModelPlugin
from flatland_server.plugins.plugin_loader import PluginLoader
from flatland_server.testing import WorldFiles
from flatland_server.testing.harness import Harness

pytestmark = pytest.mark.slow

RED, BLUE = (255, 0, 0), (0, 0, 255)
SVG = "{http://www.w3.org/2000/svg}"
LASER = (
    "{type: Laser, name: laser, body: base, range: 20, "
    "angle: {min: -0.5, max: 0.5, increment: 0.01}}"
)


@pytest.fixture
def files(tmp_path):
    return WorldFiles(tmp_path)


@pytest.fixture
def simulation(files) -> Harness:
    """A square room of 8 m with a red disc of 1 m radius at (2, 1) and a sensor around it."""
    return load(files)


def load(files, *, plugins="[]", color="[0, 0, 1, 1]", loader=None) -> Harness:
    footprints = (
        "[{type: circle, radius: 1, density: 1}, "
        "{type: polygon, sensor: true, density: 1, points: [[-2, -2], [2, -2], [2, 2], [-2, 2]]}]"
    )
    files.write(
        "disc.model.yaml",
        f"bodies: [{{name: base, color: [1, 0, 0, 1], footprints: {footprints}}}]\n"
        f"plugins: {plugins}\n",
    )
    walls = [(-4, -4, 4, -4), (4, -4, 4, 4), (4, 4, -4, 4), (-4, 4, -4, -4)]
    files.loader = loader or files.loader
    return files.load(
        f"properties: {{}}\nlayers: [{{name: map, map: {files.walls('room', *walls)}, "
        f"color: {color}}}]\nmodels: [{{name: disc, model: disc.model.yaml, pose: [2, 1, 0]}}]\n"
    )


def render(world, size=None, *, follow=None, width=10.0, **shown):
    renderer = Renderer(world)
    return to_array(renderer.image(renderer.view(size, follow=follow, width=width), **shown))


def where(picture, color, tolerance=3) -> np.ndarray:
    """The rows and columns of the pixels of a colour."""
    return np.argwhere((abs(np.asarray(picture).astype(int) - color) <= tolerance).all(axis=2))


def test_walls_and_bodies_are_where_they_are_in_the_world(simulation, files):
    picture = render(simulation.world, (400, 400))

    assert (picture.shape, picture.dtype) == ((400, 400, 3), np.uint8)
    scale = (400 - 2 * 10) / 8
    discs, walls = where(picture, RED), where(picture, BLUE)
    middle = (200 - 1 * scale, 200 + 2 * scale)
    assert discs.mean(axis=0) == pytest.approx(middle, abs=1.0)
    assert len(discs) == pytest.approx(np.pi * scale**2, rel=0.1)
    assert walls.min() == pytest.approx(10, abs=2)
    assert walls.max() == pytest.approx(390, abs=2)
    simulation.world.move_model("disc", Pose(2, 1, 0.3))
    picture = render(simulation.world, (400, 400))
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 30  # of edges that are anti-aliased
    white = load(files, color="[1, 1, 1, 1]")
    assert len(where(render(white.world, (400, 400)), (153, 153, 153))) > 1000


def test_a_changed_footprint_is_drawn(simulation):
    renderer = Renderer(simulation.world)
    view = renderer.view((400, 400))
    renderer.image(view)

    simulation.world.models["disc"].set_footprint("base", 0, Circle((0.0, 0.0), 0.5))

    pixels = len(where(renderer.image(view), RED))
    assert pixels == pytest.approx(np.pi * (0.5 * view.scale) ** 2, rel=0.1)


def test_a_sensor_is_an_outline(simulation):
    picture = render(simulation.world, (400, 400))

    inside_sensor = picture[200 - int((1 + 1.5) * 47.5), 200 + int((2 - 1.5) * 47.5)]
    outside = picture[200 + int(1.5 * 47.5), 200 - int(0.5 * 47.5)]
    assert inside_sensor.tolist() == outside.tolist() == [238, 238, 236]


def test_a_picture_follows_a_model(simulation):
    for x in (2.0, -1.3):
        simulation.world.move_model("disc", Pose(x, 0.7, 0))
        picture = render(simulation.world, (300, 200), follow="disc", width=6.0)

        discs = where(picture, RED)
        assert discs.mean(axis=0) == pytest.approx((100, 150), abs=1.5)
        assert np.ptp(discs[:, 1]) == pytest.approx(100, abs=4)


def test_pictures_do_not_depend_on_earlier_pictures(simulation):
    used = Renderer(simulation.world)
    for x in np.linspace(-1, 2, 4):
        simulation.world.move_model("disc", Pose(x, 1, 0))
        for view in (used.view((160, 120)), used.view((300, 200), follow="disc")):
            assert used.image(view) == Renderer(simulation.world).image(view)


def test_walls_are_drawn_once_for_all_pictures(simulation, monkeypatch):
    renderer = Renderer(simulation.world)
    drawn = []
    draw = rendering.scene.draw_walls
    monkeypatch.setattr(
        "flatland2d.rendering.renderer.draw_walls",
        lambda *arguments: (drawn.append(1), draw(*arguments)),
    )
    view = renderer.view((300, 300))

    renderer.image(view)
    first = len(drawn)
    renderer.image(view)
    simulation.reset()
    renderer.image(view)

    assert first > 0
    assert len(drawn) == first


def test_new_walls_are_drawn(simulation):
    renderer = Renderer(simulation.world)
    view = renderer.view((400, 400))
    before = len(where(renderer.image(view), BLUE))

    simulation.world.add_walls("map", np.array([[-3.0, -3.0, 3.0, -3.0]]))

    assert len(where(renderer.image(view), BLUE)) > before + 250


def test_pictures_survive_a_reset_and_deleted_models(simulation):
    renderer = Renderer(simulation.world)
    first = renderer.image(renderer.view((300, 300)))

    assert renderer.image(renderer.view((300, 300))) == first
    simulation.reset()
    assert renderer.image(renderer.view((300, 300))) == first
    simulation.world.delete_model("disc")
    assert len(where(renderer.image(renderer.view((300, 300))), RED)) == 0


def test_pictures_change_nothing(files):
    def run(draws: bool):
        simulation = load(files, plugins=f"[{LASER}]")
        for _ in range(8):
            simulation.run()
            if draws:
                render(simulation.world, (80, 60), sensors=True, names=True)
        return simulation.save_state(), list(simulation.last("/scan").ranges)

    assert run(True) == run(False)


def test_a_lidar_shows_its_beams_and_returns_if_asked(files):
    simulation = load(files, plugins=f"[{LASER}]")

    without = render(simulation.world, (400, 400))
    picture = render(simulation.world, (400, 400), sensors=True)

    changes = abs(picture.astype(int) - without).max(axis=2)
    beams, returns = (np.argwhere(changes > least) for least in (0, 60))
    assert len(beams) > 5 * len(returns)
    # Two metres ahead is the wall, at x = 4; the fan is 2 x tan(0.5) = 1.1 m to each side.
    assert returns[:, 1] == pytest.approx(390, abs=4)
    assert np.ptp(returns[:, 0]) == pytest.approx(2 * 2 * np.tan(0.5) * 47.5, abs=8)


class Pointer(ModelPlugin):
    """Draws a green dot in the middle of the world, or fails."""

    fails = False

    def on_initialize(self, config):
        config.finish()

    def draw(self, canvas, timekeeper):
        assert not self.fails, "a broken pen"
        canvas.dots([(0.0, 0.0)], (0.0, 1.0, 0.0, 1.0), size=20.0)
        canvas.lines(np.empty((0, 4)), (0.0, 1.0, 0.0, 1.0))
        canvas.dots(np.empty((0, 2)), (0.0, 1.0, 0.0, 1.0))
        canvas.path([(0.0, 0.0)], (0.0, 1.0, 0.0, 1.0))


class PointerLoader(PluginLoader):
    def load(self, type, base):
        return Pointer


def test_a_plugin_draws_itself(files):
    simulation = load(files, plugins="[{type: Pointer, name: it}]", loader=PointerLoader())

    picture = render(simulation.world, (400, 400), sensors=True)

    green = where(picture, (0, 255, 0))
    assert green.mean(axis=0) == pytest.approx((200, 200), abs=1.0)
    assert len(green) == pytest.approx(np.pi * 10**2, rel=0.2)
    document = Renderer(simulation.world).svg(sensors=True)
    assert 'stroke="rgb(0,255,0)"' in document


def test_a_plugin_that_fails_to_draw_is_switched_off(files, caplog, monkeypatch):
    simulation = load(files, plugins="[{type: Pointer, name: it}]", loader=PointerLoader())
    monkeypatch.setattr(Pointer, "fails", True)

    with caplog.at_level(logging.ERROR):
        render(simulation.world, (400, 400), sensors=True)
        render(simulation.world, (400, 400), sensors=True)

    assert len(caplog.records) == 1
    assert "failed in draw" in caplog.text
    assert [failure.label for failure in simulation.world.plugin_failures] == ["disc/it"]


def test_a_trail_is_drawn_below_the_models(simulation):
    trail = np.array([(-3, -3), (3, -3)])

    picture = render(simulation.world, (400, 400), trails=[trail])

    row = 200 + round(3 * 47.5)
    assert (picture[row - 3 : row + 4, 100:300].min(axis=0)[:, 0] < 180).all()


def test_an_svg_file_shows_the_same(simulation, tmp_path):
    renderer = Renderer(simulation.world)
    path = tmp_path / "world.svg"

    rendering.save(path, renderer, renderer.view((400, 300)), names=True)

    root = ElementTree.parse(path).getroot()
    assert (root.get("width"), root.get("height")) == ("400", "300")
    [disc] = root.findall(f"{SVG}circle")
    center = renderer.view((400, 300)).pixels([(2, 1)])[0]
    assert (float(disc.get("cx")), float(disc.get("cy"))) == pytest.approx(tuple(center), abs=0.01)
    assert disc.get("fill") == "rgb(255,0,0)"
    assert root.find(f"{SVG}text").text == "disc"


@pytest.mark.parametrize("suffix", ["png", "PNG", "jpg"])
def test_a_picture_is_saved_by_the_suffix_of_its_name(simulation, tmp_path, suffix):
    path = tmp_path / f"world.{suffix}"

    renderer = Renderer(simulation.world)
    view = renderer.view((40, 30))
    rendering.save(path, renderer, view)

    with Image.open(path) as image:
        assert image.size == (40, 30)
    png = Image.open(io.BytesIO(rendering.to_png(renderer.image(view))))
    assert png.convert("RGB") == renderer.image(view)


@pytest.mark.parametrize("name", ["world.doc", "world", "no/such/folder/world.svg"])
def test_a_file_that_cannot_be_written_is_an_error(simulation, tmp_path, name):
    with pytest.raises(FlatlandError, match="cannot be written"):
        rendering.save(tmp_path / name, Renderer(simulation.world))


def test_a_world_without_anything_has_a_picture(files):
    world = files.load("{properties: {}, layers: []}").world

    assert render(world).shape == (1600, 1600, 3)
    assert len(Renderer(world).svg()) > 100


def test_unknown_models_and_unusable_widths_are_errors(simulation):
    with pytest.raises(ModelError, match='no model "dsc" \\(did you mean "disc"'):
        render(simulation.world, follow="dsc")
    with pytest.raises(FlatlandError, match="expected a width above 0 m, found -1"):
        render(simulation.world, follow="disc", width=-1)


@pytest.mark.parametrize(
    ("scale", "cell"), [(500, 1), (14, 1), (13.9, 2), (7, 2), (5, 5), (1.4, 10), (1.3, 20)]
)
def test_the_grid_is_of_whole_metres(scale, cell):
    assert grid_cell(scale) == cell


def test_without_a_size_the_longer_side_has_1600_pixels(simulation):
    assert Renderer(simulation.world).view().size == (1600, 1600)
    assert Renderer(simulation.world).view(follow="disc").size == (800, 800)


def test_a_plot_is_in_metres(simulation, files):
    axes = Mock()
    with Simulation(files.folder / "world.yaml") as sim:
        assert sim.plot(axes) is axes

    [image] = axes.imshow.call_args.args
    assert image == Renderer(simulation.world).image()
    extent = axes.imshow.call_args.kwargs["extent"]
    assert extent == pytest.approx((-4.2, 4.2, -4.2, 4.2), abs=0.02)
    axes.set_xlabel.assert_called_once_with("x [m]")
    axes.set_ylabel.assert_called_once_with("y [m]")


def test_a_plot_without_matplotlib_is_an_error(simulation, files, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)

    with Simulation(files.folder / "world.yaml") as sim, pytest.raises(
        FlatlandError, match="pip install matplotlib"
    ):
        sim.plot()
