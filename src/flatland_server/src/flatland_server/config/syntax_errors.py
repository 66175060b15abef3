"""Errors of YAML's syntax, in words that say what to change.

The parser says what it expected in the words of its grammar, and where it noticed.
"""

import re
from pathlib import Path

import yaml

from flatland_server.exceptions import YamlError, shortened


def other_indentation(line: str) -> str:
    """A line's indentation by a space that is none in YAML, for a message; or an empty string.

    Texts that are copied from a page may have it. For YAML it is a part of the key.
    """
    first = line.lstrip(" ")[:1]
    if first.isascii() or not first.isspace():
        return ""
    return f"lines are indented by spaces, found the character U+{ord(first):04X}"


def syntax_error(path: Path, text: str, error: yaml.MarkedYAMLError) -> YamlError:
    """The error of a parser for a user."""
    mark, context, problem = error.problem_mark, error.context or "", error.problem or ""
    begin = error.context_mark or mark  # of what is incomplete
    if mark is None or begin is None:
        return YamlError(path, f"is not valid YAML: {shortened(problem)}")
    lines = [*text.splitlines(), ""]
    line, before, found = mark.line, lines[mark.line][: mark.column], text[mark.index :][:1]
    if other_indentation(lines[line]):
        problem = other_indentation(lines[line])
    elif found == "\t":
        problem = "lines are indented by spaces, found a tab"
    elif problem.startswith("found character that cannot start"):
        problem = f"expected quotes around a text that begins with {found}"
    elif problem.startswith("mapping values are not allowed"):
        while line > 0 and not lines[line - 1].strip():
            line -= 1
        if re.search(r":\s", before):
            problem = 'expected quotes around a text with ": " in it'
        elif line > 0 and _indentation(before) <= _indentation(lines[line - 1]):
            line -= 1
            problem = f'expected "key: value", found "{lines[line].strip()}"'
        else:
            problem = "expected the key in the column of the one before it, found it to the right"
    elif problem == "could not find expected ':'":
        line = begin.line
        problem = f'expected "key: value", a space after the colon, found "{lines[line].strip()}"'
    elif context.startswith("while parsing a block"):
        problem = f"expected the indentation of the list or map from line {begin.line + 1}"
        if before.strip():
            problem = f'expected the end of the line, found "{lines[line][mark.column :]}"'
    elif context:
        where = f" from line {begin.line + 1}" if begin.line != line else ""
        problem = f"{context}{where} {problem}"
    column = mark.column if line == mark.line else _indentation(lines[line])
    message = f"is not valid YAML: {shortened(problem, 120)}"
    return YamlError(path, message, line + 1, column + 1)


def _indentation(line: str) -> int:
    return len(line) - len(line.lstrip(" "))
