"""Errors of YAML's syntax, in words that say what to change.

The parser says what it expected in the words of its grammar, and where it noticed.
"""

import re
from pathlib import Path

import yaml

from flatland_server.exceptions import YamlError, shortened

# Texts that are copied from a page may have them.
_OTHER_SPACE = re.compile("^ *([\u00a0\u1680\u2000-\u200b\u202f\u205f\u3000])", re.MULTILINE)


def check_spaces(path: Path, text: str) -> None:
    """Refuses lines that begin with a space that is none in YAML: it would be part of the key.

    Raises:
        YamlError: there is one.
    """
    found = None if text.isascii() else _OTHER_SPACE.search(text)
    if found:
        line = text.count("\n", 0, found.start()) + 1
        message = f"lines are indented by spaces, found the character U+{ord(found[1]):04X}"
        raise YamlError(path, f"is not valid YAML: {message}", line, len(found[0]))


def syntax_error(path: Path, text: str, error: yaml.MarkedYAMLError) -> YamlError:
    """The error of a parser for a user.

    Args:
        path: of the file.
        text: its content.
        error: the parser's.
    """
    mark, context, problem = error.problem_mark, error.context or "", error.problem or ""
    begin = error.context_mark or mark  # of what is incomplete
    if mark is None or begin is None:
        return YamlError(path, f"is not valid YAML: {shortened(problem)}")
    lines = [*text.splitlines(), ""]
    line, before, found = mark.line, lines[mark.line][: mark.column], text[mark.index :][:1]
    if found == "\t":
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
