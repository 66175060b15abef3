"""The public fronts: `flatland_server` for plugins, `flatland2d` for programs."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from catkin_pkg.packages import find_packages

import flatland2d
import flatland_server

SRC = Path(__file__).resolve().parents[3]
FRONTS = [flatland_server, flatland2d]

of_each_front = pytest.mark.parametrize("front", FRONTS, ids=lambda front: front.__name__)


@of_each_front
def test_all_names_exist_are_sorted_and_public(front):
    names = front.__all__

    assert names == sorted(names, key=lambda name: (not name.isupper(), name.islower(), name))
    assert len(names) == len(set(names))
    assert [name for name in names if not hasattr(front, name)] == []
    assert [name for name in names if name.startswith("_")] == []


@of_each_front
def test_nothing_public_is_imported_besides_all(front):
    name = front.__name__
    module = ast.parse((SRC / name / "src" / name / "__init__.py").read_text())
    imported = {
        alias.name
        for node in ast.walk(module)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if not alias.name.startswith("_")
    }

    assert imported == set(front.__all__)


def test_packages_and_citation_have_the_librarys_version():
    packages = find_packages(str(SRC)).values()

    assert len(packages) > 5
    assert {package.version for package in packages} == {flatland2d.__version__}
    citation = yaml.safe_load((SRC.parent / "CITATION.cff").read_text())
    assert citation["version"] == flatland2d.__version__


@of_each_front
def test_the_types_are_declared(front):
    assert any(Path(folder, "py.typed").exists() for folder in front.__path__)


def test_the_lua_worker_loads_neither_numpy_nor_the_core(tmp_path):
    # Whatever lies in the working directory is not imported either.
    (tmp_path / "json.py").write_text("raise SystemExit('imported from the working directory')")
    worker = Path(inspect.getfile(flatland_server.YamlReader)).with_name("lua_worker.py")
    script = f"""
import runpy, sys
sys.argv = [{str(worker)!r}]
try:
    runpy.run_path({str(worker)!r}, run_name="lua_worker")
finally:
    print([name for name in ("numpy", "flatland_server", "yaml") if name in sys.modules])
"""
    result = subprocess.run(
        [sys.executable, "-I", "-c", script], cwd=tmp_path, capture_output=True, text=True
    )

    assert (result.stdout.strip(), result.stderr) == ("[]", "")
