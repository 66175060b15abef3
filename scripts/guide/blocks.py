"""The code blocks of a Markdown page, and what the comments before them say of them.

    <!-- not run: needs a screen -->      it is shown, and not run; with the reason
    <!-- part of: FILE -->                it is an excerpt, word for word
    <!-- runs on -->                      its last program goes on until the page ends
    <!-- prints then -->                  what that program prints later
    <!-- ends with 1 -->                  the exit code of a console's last command
    <!-- with the files of: PAGE -->      that page's files are there
    <!-- instead: COMMAND -->             what tests run in place of a console's command

A Python block may begin with `# needs: MODULE`; a file's block begins with `# file: NAME`, or with
`# in NAME` if it is added to the end of a file.

usage: blocks.py PAGE    prints the Python of a page as one program, for type checks
"""

import re
import sys
from pathlib import Path
from typing import List, NamedTuple, Tuple

FENCE = re.compile(
    r"(?P<notes>(?:^<!-- [^\n]* -->\n+)*)"
    r"^(?P<indent> *)```(?P<language>\w*)[^\n]*\n(?P<text>.*?)^(?P=indent)```$",
    re.DOTALL | re.MULTILINE,
)
FILE = re.compile(r"\A(?:#|//|<!--) (?P<how>file:|in) (?P<name>\S+)(?: -->)?\n")


class Block(NamedTuple):
    """A code block of a page."""

    language: str
    text: str
    line: int
    """Of the page, on which the text begins."""
    notes: Tuple[str, ...]
    """The comments before it."""

    def note(self, name: str) -> str:
        """The rest of the comment that begins so, such as the reason of `not run:`; or ""."""
        for each in self.notes:
            if each.startswith(name):
                return each[len(name) :].strip() or name
        return ""

    @property
    def file(self) -> str:
        """The name of the file that it is, or is added to; or ""."""
        match = FILE.match(self.text)
        return match["name"] if match else ""

    @property
    def is_addition(self) -> bool:
        """Whether it is added to the end of its file."""
        match = FILE.match(self.text)
        return match is not None and match["how"] == "in"

    @property
    def need(self) -> str:
        """The module without which it cannot run, or ""."""
        match = re.match(r"# needs: (\w+)", self.text)
        return match[1] if match else ""


def blocks_of(page: Path) -> List[Block]:
    """The blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    blocks = []
    for match in FENCE.finditer(text):
        indent = match["indent"]
        lines = [line[len(indent) :] for line in match["text"].splitlines(keepends=True)]
        notes = re.findall(r"^<!-- (.*?) -->$", match["notes"], re.MULTILINE)
        line = text.count("\n", 0, match.start("text")) + 1
        blocks.append(Block(match["language"], "".join(lines), line, tuple(notes)))
    return blocks


def program_of(page: Path) -> str:
    """The Python blocks of a page, at their lines, with empty lines in place of all else."""
    lines = [""] * (page.read_text(encoding="utf-8").count("\n") + 1)
    for block in blocks_of(page):
        if block.language == "python" and not block.file:
            code = block.text.splitlines()
            lines[block.line - 1 : block.line - 1 + len(code)] = code
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    print(program_of(Path(sys.argv[1])), end="")
