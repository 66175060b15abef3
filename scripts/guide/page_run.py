"""Runs the blocks of a page in order, in a folder of its own.

Files are written as they are pasted, Python runs as one program, commands run, and what they print
is compared. At the end, each world, model and map file that the page has written is loaded.

usage: page_run.py PAGE FOLDER    leaves out the parts that need ROS
"""

import contextlib
import importlib.util
import os
import re
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Sequence

from blocks import Block, blocks_of, needs_of
from console import Shell, commands_of, pattern_of, without_colors

from flatland2d import FlatlandError
from flatland2d.cli.check import load
from flatland_server.config.yaml_preprocessor import YamlPreprocessor

ROOT = Path(__file__).resolve().parents[2]


class PageError(AssertionError):
    """A block does not do what the page says."""


class PageRun:
    """One reading of a page.

    Args:
        page: the Markdown file.
        folder: an empty one.
        environment: environment variables of its shell.
        has_ros: whether ROS is installed; if not, parts that need it are left out.
    """

    def __init__(
        self,
        page: Path,
        folder: Path,
        environment: Mapping[str, str],
        has_ros: bool = True,
    ) -> None:
        self._page = page
        self._needs = needs_of(page)
        self._has_ros = has_ros
        self._folder = folder
        self._shell = Shell(folder, environment)
        self._names: Dict[str, Any] = {"__name__": "__main__"}
        self._written: List[str] = []

    def run(self) -> None:
        """Runs all blocks.

        Raises:
            PageError: with the page's line.
        """
        try:
            with _inside(self._folder):
                if self._needs and self._needs.files:  # of the page that this one builds on
                    for block in blocks_of(self._page.parent / self._needs.files):
                        if block.file:
                            self._write(block)
                blocks = blocks_of(self._page)
                for block, following in zip(blocks, [*blocks[1:], None]):
                    is_shown = following is not None and following.is_output
                    self._run_block(block, following.text if following and is_shown else "")
            self._load_files()
        finally:
            self._shell.close()

    def _run_block(self, block: Block, output: str) -> None:
        """Runs a block."""
        is_missing = block.need and importlib.util.find_spec(block.need) is None
        if block.is_output or block.note("not run:") or is_missing:
            return
        if block.uses_ros and not self._has_ros:
            if not (self._needs and self._needs.has_ros_parts):
                raise self._error(block, "the page says that it runs by pip, and this needs ROS")
            return
        source = block.note("part of:")
        if source:  # an excerpt, of a file named from the repository's folder
            if block.text not in (ROOT / source).read_text(encoding="utf-8"):
                raise self._error(block, f"{source} has no such part")
        elif block.file:
            self._write(block)
        elif block.language == "python":
            self._run_python(block)
        elif block.language == "bash":
            self._run_commands(block, output)
        elif block.language == "output":  # with `prints then`
            found = self._shell.wait_for(block.text)
            if found is not None:
                raise self._difference(block, "the last program", block.text, found)
        elif block.language == "console":
            raise self._error(block, 'expected commands as "bash", and "output" after them')
        elif block.language != "text":  # shown alone, such as definitions of messages
            message = f'a reason to leave this "{block.language}" block out'
            raise self._error(block, f"expected the name of a file, or {message}")

    def _write(self, block: Block) -> None:
        path = self._folder / block.file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")
        self._written.append(block.file)

    def _run_python(self, block: Block) -> None:
        source = "\n" * (block.line - 1) + block.text
        try:
            exec(compile(source, str(self._page), "exec"), self._names)
        except (Exception, SystemExit):
            raise self._error(block, traceback.format_exc()) from None

    def _run_commands(self, block: Block, output: str) -> None:
        commands = commands_of(block.text)
        commands[0] = block.note("instead:") or commands[0]
        if block.note("runs on"):
            last = commands.pop()
        codes = [0] * (len(commands) - 1) + [int(block.note("ends with") or 0)]
        printed = [self._run_command(block, *each) for each in zip(commands, codes)]
        if block.note("runs on"):
            found = self._shell.start(last, output)
            if found is not None:
                raise self._difference(block, f"$ {last}", output, found)
        elif not pattern_of(output).match("".join(printed)):
            shown = "".join(f"$ {each}\n{found}" for each, found in zip(commands, printed))
            raise self._difference(block, "commands", output, shown)

    def _run_command(self, block: Block, command: str, code: int) -> str:
        """Runs a command that ends with this exit code, and returns what it prints."""
        try:
            printed, ended_with = self._shell.run(command)
        except subprocess.TimeoutExpired as error:
            raise self._error(block, f"$ {command}\ntook more than {error.timeout} s") from None
        found = without_colors(printed)
        if ended_with != code:
            raise self._error(block, f"$ {command}\nended with {ended_with}, not {code}:\n{found}")
        return f"{found.rstrip()}\n" if found.strip() else ""

    def _load_files(self) -> None:
        """Loads the world, model and map files; skips those with the page's own plugins."""
        text = "".join(path.read_text() for path in self._folder.rglob("*.py"))
        classes = re.findall(r"^class (\w+)\((?:Model|World)Plugin", text, re.MULTILINE)
        preprocessor = YamlPreprocessor()
        for name in dict.fromkeys(self._written):
            path = self._folder / name
            if path.suffix == ".yaml" and _is_loadable(path, classes):
                try:
                    load(path, preprocessor)
                except FlatlandError as error:
                    raise PageError(f"{self._page}: {name}: {error}") from None

    def _difference(self, block: Block, of: str, shown: str, found: str) -> PageError:
        text = f"{of}:\nthe page shows\n{shown or 'nothing'}\nand it is\n{found}"
        return self._error(block, text)

    def _error(self, block: Block, message: str) -> PageError:
        return PageError(f"{self._page}:{block.line}: {message}")


def _is_loadable(path: Path, classes: Sequence[str]) -> bool:
    text = path.read_text(encoding="utf-8")
    if any(re.search(rf"\b{name}\b|model: \w+", text) for name in classes):
        return False
    return any(f"\n{key}:" in f"\n{text}" for key in ("bodies", "layers", "origin"))


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """Works in a folder: its modules can be imported, and are unloaded afterwards."""
    before, modules = Path.cwd(), set(sys.modules)
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        os.chdir(before)
        for name in set(sys.modules) - modules:
            if str(getattr(sys.modules[name], "__file__", "")).startswith(str(folder)):
                del sys.modules[name]


if __name__ == "__main__":
    PageRun(Path(sys.argv[1]), Path(sys.argv[2]), os.environ, has_ros=False).run()
