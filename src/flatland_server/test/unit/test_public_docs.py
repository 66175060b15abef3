"""The docstrings of public names: each parameter is described, and no other; errors are, too."""

import ast
import importlib
import inspect
import re
from pathlib import Path

import pytest

import flatland_server
from flatland_server import _core

PACKAGES = ("flatland2d", "flatland_server", "flatland_server.testing", "flatland_gym")
PUBLIC = [
    pytest.param(value, id=f"{package}.{name}")
    for package in PACKAGES
    for name, value in vars(importlib.import_module(package)).items()
    if name in importlib.import_module(package).__all__
    and (inspect.isclass(value) or inspect.isfunction(value))
    and value.__module__.startswith("flatland")
]


def described(doc, section):
    """The names in a section of a docstring."""
    found = re.search(rf"^{section}:\n((?:    .*\n)*)", doc + "\n", re.MULTILINE)
    return re.findall(r"^    (\w+):", found[1], re.MULTILINE) if found else []


def parameters(function):
    return [name for name in inspect.signature(function).parameters if name != "self"]


def functions_of(value):
    """A function itself, or the public methods of a class: inherited ones too, if they are ours."""
    if inspect.isfunction(value):
        yield value.__name__, value
        return
    for name in dir(value):
        owner = next((each for each in value.__mro__ if name in vars(each)), object)
        is_ours = owner.__module__.startswith("flatland") and not name.startswith("_")
        if is_ours and inspect.isroutine(getattr(value, name)):
            yield name, getattr(value, name)


def raises(function):
    """True if a function's own code raises an error other than NotImplementedError."""
    code = inspect.unwrap(getattr(function, "__func__", function))
    source = inspect.getsource(code) if inspect.isfunction(code) else ""  # nothing in the core
    return re.search(r"^ +raise (?!NotImplementedError|TypeError)[A-Z]", source, re.MULTILINE)


@pytest.mark.parametrize("value", PUBLIC)
def test_parameters_and_errors_of_a_public_name_are_described(value):
    assert inspect.getdoc(value) or "_core" in value.__module__  # described in _core.pyi
    for name, function in functions_of(value):
        doc = inspect.getdoc(function) or ""
        if not doc.startswith("Deprecated"):
            assert (name, described(doc, "Args")) == (name, parameters(function))
            assert "Raises:" in doc or not raises(function), name
            assert not re.match("What|Which|Those|Who|How", doc), name


@pytest.mark.parametrize(
    "value",
    [each for each in PUBLIC if inspect.isfunction(getattr(each.values[0], "__init__", None))],
)
def test_parameters_of_a_public_class_are_described(value):
    """As parameters or as attributes, by the class or a base."""
    docs = [inspect.cleandoc(each.__doc__ or "") for each in value.__mro__[:-1]]
    told = {name for doc in docs for name in described(doc, "Args") + described(doc, "Attributes")}

    assert set(parameters(value)) <= told
    assert set(described(docs[0], "Args")) <= set(parameters(value))


def test_the_core_has_the_docstrings_of_its_stub():
    [stub] = [
        path for folder in flatland_server.__path__ for path in Path(folder).glob("_core.pyi")
    ]
    classes = [each for each in ast.parse(stub.read_text()).body if isinstance(each, ast.ClassDef)]
    compared = 0
    for each in classes:
        if each.name.startswith("_"):
            continue
        cls = getattr(_core, each.name)
        assert inspect.getdoc(cls) == ast.get_docstring(each)
        for member in each.body:
            doc = ast.get_docstring(member) if isinstance(member, ast.FunctionDef) else None
            if doc:
                assert doc in inspect.getdoc(getattr(cls, member.name)), member.name
                compared += 1

    assert compared > 100
    assert str(inspect.signature(_core.Body.apply_force)) == "(self, force, point=None)"
    assert str(inspect.signature(_core.World(1, 1).step)) == "(dt)"
