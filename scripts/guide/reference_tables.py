"""The generated parts of the reference: tables of keys and of arguments, and message definitions.

A page marks where they are by comments, which Markdown does not show:

    <!-- keys of plugin Laser -->                      all keys of a plugin
    <!-- keys of plugin OmniDrive beyond DiffDrive --> those that the other has not, or otherwise
    <!-- keys of world -->                             of a kind of file, without its sections
    <!-- keys of world layers[] -->                    of a section
    <!-- arguments of flatland_server server.launch -->
    <!-- parameters of navigator -->                   the private parameters of a node
    <!-- parameters of NODE beyond PACKAGE FILE -->    those that are no arguments of a launch file
    <!-- definitions of flatland_msgs msg -->          up to <!-- end -->

In a table of keys, the code gives all cells but the last, the meaning. Meanings are written in the
page, as are, in italics, units that the code does not know and defaults that depend on other keys.
All of these are kept when the table is made again.
"""

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Callable, Dict, List, Sequence

import samples
from key_reads import Key
from node_parameters import parameters_of

ROOT = Path(__file__).resolve().parents[2]
HEADER = "| key | type | default | meaning |\n| --- | --- | --- | --- |\n"
UNIT = re.compile(r" \[[^]`]+\]$")
MARK = re.compile(r"<!-- (keys|arguments|parameters) of ([^>]+) -->\n((?:\|.*\n)*)")
RESULT = re.compile(r"(?<=^---\n)bool success.*\nstring message.*\n?", re.M)
"""The result of a service, which the page explains once for all of them."""
DEFINITIONS = re.compile(r"<!-- definitions of (\w+) (\w+) -->\n(.*?)<!-- end -->", re.DOTALL)


def updated(text: str) -> str:
    """A page with its generated parts up to date."""
    tables: Dict[str, Callable[[str, str], str]] = {
        "keys": _keys,
        "arguments": _arguments,
        "parameters": _parameters,
    }

    def table(match: "re.Match[str]") -> str:
        kind, of, rows = match.groups()
        return f"<!-- {kind} of {of} -->\n{tables[kind](of, rows)}"

    text = MARK.sub(table, text)
    return DEFINITIONS.sub(
        lambda match: (
            f"<!-- definitions of {match[1]} {match[2]} -->\n"
            f"{_definitions(match[1], match[2])}<!-- end -->"
        ),
        text,
    )


def problems(text: str) -> List[str]:
    """Cells to be written by hand: meanings, and defaults that depend on other keys."""
    found = []
    for match in MARK.finditer(text):
        for row in match[3].splitlines()[2:]:
            cells = _cells(row)
            if not cells[-1]:
                found.append(f"{match[2]}: {cells[0]}: a meaning is missing")
            if match[1] == "keys" and not cells[2]:
                found.append(f"{match[2]}: {cells[0]}: the default depends on other keys: say how")
    return found


def keys_of(subject: str) -> List[Key]:
    """The keys that a mark asks for."""
    kind, _, rest = subject.partition(" ")
    if kind == "plugin":
        name, _, other = rest.partition(" beyond ")
        shared = set(samples.keys_of_plugin(other)) if other else set()
        return [key for key in samples.keys_of_plugin(name) if key not in shared]
    prefix = f"{rest}." if rest else ""
    found = [
        key._replace(name=key.name[len(prefix) :])
        for key in samples.keys_of_file(kind)
        if key.name.startswith(prefix)
    ]
    return [key for key in found if "[]." not in key.name]


def _keys(subject: str, rows: str) -> str:
    written = {cells[0].strip("`"): cells for cells in map(_cells, rows.splitlines()[2:])}
    keys = keys_of(subject)
    order = {name: place for place, name in enumerate(written)}
    keys.sort(key=lambda key: order.get(key.name, len(order)))
    return HEADER + "".join(_row(key, written.get(key.name, [""] * 4)) for key in keys)


def _row(key: Key, written: Sequence[str]) -> str:
    in_words = written[2] if re.fullmatch(r"\*[^*]+\*", written[2]) else ""
    is_literal = key.default and not key.default.startswith("*") and key.default != "none"
    default = f"`{key.default}`" if is_literal else key.default or in_words
    unit = f" [{key.unit}]" if key.unit else "".join(UNIT.findall(written[1]))
    cells = (f"`{key.name}`", f"{key.type}{unit}", default, written[3])
    return "|" + "|".join(f" {cell} " if cell else " " for cell in cells) + "|\n"


def _arguments(file: str, rows: str) -> str:
    text = "| argument | default | meaning |\n| --- | --- | --- |\n"
    for each in _launch_arguments(file):
        if each.get("value") is None:
            default = each.get("default")
            shown = "**required**" if default is None else f"`{default}`" if default.strip() else ""
            text += f"| `{each.get('name')}` | {shown} | {each.get('doc', '')} |\n"
    return text.replace("|  |", "| |")


def _launch_arguments(file: str) -> List[ElementTree.Element]:
    package, name = file.split()
    return ElementTree.parse(ROOT / "src" / package / "launch" / name).getroot().findall("arg")


def _parameters(subject: str, rows: str) -> str:
    node, _, file = subject.partition(" beyond ")
    arguments = {each.get("name") for each in _launch_arguments(file)} if file else set()
    written = {cells[0].strip("`~"): cells[-1] for cells in map(_cells, rows.splitlines()[2:])}
    text = "| parameter | default | meaning |\n| --- | --- | --- |\n"
    for name, default in parameters_of(node):
        if name in arguments:
            continue
        shown = str(default).lower() if isinstance(default, bool) else str(default)
        shown = f"`{shown}`" if shown else ""
        text += f"| `~{name}` | {shown} | {written.get(name, '')} |\n"
    return text.replace("|  |", "| |")


def _definitions(package: str, kind: str) -> str:
    text = ""
    for path in sorted((ROOT / "src" / package / kind).glob(f"*.{kind}")):
        definition = RESULT.sub("", path.read_text(encoding="utf-8")).rstrip()
        text += f"\n### {path.stem}\n\n```text\n{definition}\n```\n"
    return text + "\n"


def _cells(row: str) -> List[str]:
    return [cell.strip() for cell in row.strip().strip("|").split("|")]


def pages() -> List[Path]:
    """The pages with generated parts."""
    return sorted((ROOT / "docs").rglob("*.md"))


def update_all() -> List[str]:
    """Updates all pages; returns their `problems`."""
    found = []
    for path in pages():
        text = path.read_text(encoding="utf-8")
        new = updated(text)
        if new != text:
            path.write_text(new, encoding="utf-8")
            print(path.relative_to(ROOT))
        found += [f"{path.relative_to(ROOT)}: {problem}" for problem in problems(new)]
    return found


if __name__ == "__main__":
    raise SystemExit("\n".join(update_all()) or None)
