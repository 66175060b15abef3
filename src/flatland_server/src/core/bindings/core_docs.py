"""Makes the docstrings of the extension module out of its stub, for core_docs.cpp.

usage: core_docs.py _core.pyi core_docs.inc
"""

import ast
import sys
from pathlib import Path
from typing import Dict, Iterator, List, Tuple, Union

Scope = Union[ast.Module, ast.ClassDef]


def docs_of(scope: Scope, source: str) -> Iterator[Tuple[str, str]]:
    """The names and docstrings of a scope's functions, methods and properties, in order."""
    versions: Dict[str, List[Tuple[str, str]]] = {}
    for each in scope.body:
        if not isinstance(each, ast.FunctionDef):
            continue
        kinds = [getattr(kind, "id", getattr(kind, "attr", "")) for kind in each.decorator_list]
        if "setter" not in kinds:
            signature = "" if "property" in kinds else f"{each.name}{signature_of(each, source)}"
            doc = ast.get_docstring(each) or ""
            versions.setdefault(each.name, []).append((signature, doc))
    for name, found in versions.items():
        if len(found) == 1:
            [(signature, doc)] = found
            yield name, f"{signature}\n--\n\n{doc}" if signature else doc
        else:
            yield name, "\n\n".join(f"{signature}\n\n{doc}" for signature, doc in found)


def signature_of(function: ast.FunctionDef, source: str) -> str:
    """The parameters with their defaults, in the form that `inspect.signature` reads."""
    arguments = function.args
    first_default = len(arguments.args) - len(arguments.defaults)
    parts = []
    for index, each in enumerate(arguments.args):
        default = arguments.defaults[index - first_default] if index >= first_default else None
        parts.append(parameter(each, default, source))
    if arguments.kwonlyargs:
        parts.append("*")
        pairs = zip(arguments.kwonlyargs, arguments.kw_defaults)
        parts += [parameter(each, default, source) for each, default in pairs]
    return f"({', '.join(parts)})"


def parameter(argument: ast.arg, default: Union[ast.expr, None], source: str) -> str:
    """A parameter, with its default as it is written."""
    if default is None:
        return argument.arg
    return f"{argument.arg}={ast.get_source_segment(source, default)}"


def main(stub: str, table: str) -> None:
    """Writes a line for each docstring: its class or "", its name or "", and its text."""
    source = Path(stub).read_text(encoding="utf-8")
    module = ast.parse(source)
    rows = [("", "", ast.get_docstring(module) or "")]
    rows += [("", name, text) for name, text in docs_of(module, source)]
    for each in module.body:
        if isinstance(each, ast.ClassDef) and not each.name.startswith("_"):
            rows.append((each.name, "", ast.get_docstring(each) or ""))
            rows += [(each.name, name, text) for name, text in docs_of(each, source)]
    lines = [f'{{"{scope}", "{name}", R"doc({text})doc"}},\n' for scope, name, text in rows]
    Path(table).write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
