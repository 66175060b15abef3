"""The process in which $eval is evaluated: how it starts and ends, and what it imports."""

import sys

import pytest

from flatland_server.config import lua
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.exceptions import YamlError

IMPORTED_BY_THE_WORKER = ["json", "lupa", "re", "resource"]


@pytest.fixture
def preprocessor():
    preprocessor = YamlPreprocessor()
    yield preprocessor
    preprocessor.close()


@pytest.fixture
def evaluate(preprocessor, files):
    """Evaluates an expression, and returns the text of its value."""

    def evaluate(code: str) -> str:
        path = files.write("file.yaml", f"value: $eval {code}\n")
        return preprocessor.read(path).value[0][1].value

    return evaluate


def plant(folder, modules) -> None:
    """Writes modules that end the process that imports them."""
    folder.mkdir()
    for module in modules:
        (folder / f"{module}.py").write_text("raise SystemExit('imported')")


@pytest.mark.parametrize("place", ["the working directory", "PYTHONPATH"])
def test_the_worker_imports_nothing_from_the_users_folders(good_files, monkeypatch, place):
    planted = good_files.folder / "planted"
    plant(planted, IMPORTED_BY_THE_WORKER)
    if place == "PYTHONPATH":
        monkeypatch.setenv("PYTHONPATH", str(planted))
    else:
        monkeypatch.chdir(planted)
    good_files.edit("world.yaml", "pose: [1, 2, 0.5]", 'pose: "$eval {1, 1 + 1, 0.5}"')

    world = good_files.load()

    assert tuple(world.get_model("robot").pose) == pytest.approx((1, 2, 0.5))


def test_without_lupa_the_error_tells_how_to_check_for_it(files, evaluate, monkeypatch):
    worker = files.write("worker.py", "import no_such_module")
    monkeypatch.setattr(lua, "_WORKER", worker)

    with pytest.raises(YamlError) as caught:
        evaluate("1 + 1")

    assert files.without_folder(str(caught.value)) == (
        "file.yaml:1: $eval: Lua does not start: is lupa installed? "
        f"Try {sys.executable} -I -c 'import lupa', in: 1 + 1"
    )


def test_the_worker_ends_with_the_preprocessor(evaluate, preprocessor):
    assert evaluate("1 + 1") == "2"
    worker = preprocessor._expressions._lua._worker
    assert worker is not None

    preprocessor.close()

    assert worker.poll() is not None


def test_without_expressions_there_is_no_worker(files, preprocessor):
    preprocessor.read(files.write("file.yaml", "value: 1\n"))

    assert preprocessor._expressions._lua._worker is None


def test_a_worker_that_is_killed_is_an_error_and_is_started_again(evaluate, preprocessor):
    evaluate("1")
    preprocessor._expressions._lua._worker.kill()
    preprocessor._expressions._lua._worker.wait()

    with pytest.raises(YamlError):
        evaluate("1")

    assert evaluate("2") == "2"
