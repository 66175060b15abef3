"""The code blocks of a Markdown page, and what the page says of them.

A reader pastes a block as it is: a file's block, which begins with a comment `file: NAME`, into
that file; a `bash` block into a shell. An `output` block after it is what its commands print.

The line **Needs** below a page's title says with which installation it runs: see `Needs`. Comments
before a block, which readers do not see, are for tests:

    <!-- not run: needs a screen -->      it is shown, and not run; with the reason
    <!-- part of: FILE -->                it is an excerpt, word for word
    <!-- runs on -->                      its last program goes on until the page ends
    <!-- prints then -->                  what that program prints later
    <!-- ends with 1 -->                  the exit code of its last command
    <!-- instead: COMMAND -->             what tests run in place of its first command

A block with the comment `# needs: MODULE` is left out where that module is not installed.

usage: blocks.py PAGE    prints the Python of a page as one program, for type checks
"""

import re
import sys
from pathlib import Path
from typing import List, NamedTuple, Optional, Tuple

FENCE = re.compile(
    r"(?P<notes>(?:^<!-- [^\n]* -->\n+)*)"
    r"^(?P<indent> *)```(?P<language>\w*)[^\n]*\n(?P<text>.*?)^(?P=indent)```$",
    re.DOTALL | re.MULTILINE,
)
FILE = re.compile(r"\A(?:#|<!--) file: (?P<name>\S+)(?: -->)?\n")
NEEDS = re.compile(
    r"^\*\*Needs\*\* \[(?P<installation>ROS or pip|ROS|pip)(?: with the extra `(?P<extra>\w+)`)?\]"
    r"\([\w./]*install\.md\)(?P<has_ros_parts> \(ROS for the `ros...` commands\))?"
    r"(?:, and the files of \[[^]]+\]\((?P<files>[^)]+)\))?\.$",
    re.MULTILINE,
)
ROS = re.compile(r"\bros(?:bag|launch|node|pack|param|run|service|topic)\b")


class Block(NamedTuple):
    """A code block of a page."""

    language: str
    text: str
    line: int
    """The line of the page on which the text begins."""
    notes: Tuple[str, ...]
    """The comments before it."""

    def note(self, name: str) -> str:
        """The text after `name` in a comment, such as the reason after `not run:`; or ""."""
        for each in self.notes:
            if each.startswith(name):
                return each[len(name) :].strip() or name
        return ""

    @property
    def file(self) -> str:
        """The name of the file that it is, or ""."""
        match = FILE.match(self.text)
        return match["name"] if match else ""

    @property
    def uses_ros(self) -> bool:
        """True if its commands need ROS."""
        return self.language == "bash" and ROS.search(self.text) is not None

    @property
    def is_output(self) -> bool:
        """True if it is the output of the block before it."""
        return self.language == "output" and not self.note("prints then")

    @property
    def need(self) -> str:
        """The module that it needs, or ""."""
        match = re.search(r"^# needs: (\w+)", self.text, re.MULTILINE)
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


class Needs(NamedTuple):
    """The installation and the files that a page begins with, as its line **Needs** says."""

    ros: bool
    """True if it runs with ROS."""
    pip: bool
    """True if it runs by pip alone."""
    extra: str
    """The extra to install by pip, or ""."""
    has_ros_parts: bool
    """True if it has parts that do not run by pip alone."""
    files: str
    """Relative path of the page with the files that must exist, or ""."""


def needs_of(page: Path) -> Optional[Needs]:
    """The line **Needs** of a page."""
    match = NEEDS.search(page.read_text(encoding="utf-8"))
    if match is None:
        return None
    return Needs(
        ros="ROS" in match["installation"] or match["has_ros_parts"] is not None,
        pip="pip" in match["installation"],
        extra=match["extra"] or "",
        has_ros_parts=match["has_ros_parts"] is not None,
        files=match["files"] or "",
    )


def program_of(page: Path) -> str:
    """The Python blocks of a page at their line numbers; all other lines are empty."""
    lines = [""] * (page.read_text(encoding="utf-8").count("\n") + 1)
    for block in blocks_of(page):
        if block.language == "python" and not block.file:
            code = block.text.splitlines()
            lines[block.line - 1 : block.line - 1 + len(code)] = code
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    print(program_of(Path(sys.argv[1])), end="")
