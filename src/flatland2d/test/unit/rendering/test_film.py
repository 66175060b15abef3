"""Notebooks show animations, batches and environments."""

import io

import numpy as np
import pytest
from PIL import Image

from flatland2d import Animation, FlatlandError, Simulation, SimulationBatch


def pictures(content):
    image = Image.open(content if isinstance(content, str) else io.BytesIO(content))
    found = []
    for index in range(image.n_frames):
        image.seek(index)
        found.append(np.array(image.convert("RGB")))
    return image, found


@pytest.fixture
def film():
    film = Animation(fps=10)
    with Simulation("test_room") as simulation:
        for _ in range(3):
            simulation.models["turtlebot"].command(1.0, 0.0)
            film.add(simulation.step(100).render((80, 60), follow="turtlebot"))
    return film


def test_a_notebook_plays_an_animation(film):
    image, found = pictures(film._repr_png_())

    assert len(found) == len(film) == 3
    assert image.info["duration"] == 100
    assert [np.array_equal(a, np.array(b)) for a, b in zip(found, film._pictures)] == [True] * 3
    assert not np.array_equal(found[0], found[2])


@pytest.mark.parametrize("suffix", [".gif", ".png"])
def test_an_animation_is_written(film, tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    film.save(path)
    assert len(pictures(str(path))[1]) == 3


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda film, folder: Animation(0), "expected a rate above 0, found 0"),
        (lambda film, folder: film.add(None), "expected a picture as uint8"),
        (lambda film, folder: film.add(np.zeros((60, 80, 3))), "expected a picture as uint8"),
        (lambda film, folder: film.add(np.zeros((6, 8, 3), np.uint8)), r"found \(8, 6\)"),
        (lambda film, folder: film.save(folder / "a.avi"), "expected a file .gif, .png or .webp"),
        (lambda film, folder: film.save(folder / "no" / "a.gif"), "cannot be written: No such"),
        (lambda film, folder: Animation().save(folder / "a.gif"), "the animation is empty"),
    ],
)
def test_wrong_calls_are_refused(film, tmp_path, call, message):
    with pytest.raises(FlatlandError, match=message):
        call(film, tmp_path)
    assert len(film) == 3
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("count", "size"), [(1, (240, 180)), (5, (728, 364)), (40, (728, 548))])
def test_a_notebook_shows_the_first_environments_of_a_batch(count, size):
    with SimulationBatch("test_room", count) as batch:
        image, [found] = pictures(batch._repr_png_())
        assert image.size == size
        first = batch.view(0).render((240, 180), follow=batch.robot)
        assert np.array_equal(found[:180, :240], first)
