"""Does what a page says, in the order of its blocks, in a folder of its own.

Files are written, Python runs as one program, shell commands run, and what they print is compared.
At the end, each world, model and map file that the page has written is loaded.
"""

import contextlib
import importlib.util
import os
import re
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence

from blocks import FILE, Block, blocks_of
from console import Command, Shell, commands_of, pattern_of, without_colors
from forks import Forks

from flatland_server import FlatlandError
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.tools.check_world import load

SHOWN = "text"
"""The language of blocks that are neither files nor programs, such as definitions of messages."""


ROOT = Path(__file__).resolve().parents[2]


class PageError(AssertionError):
    """A block does not do what the page says."""


class PageRun:
    """One reading of a page.

    Args:
        page: the Markdown file.
        folder: an empty one.
        environment: for its shell.
        forks: start Python programs; see `Shell`.
    """

    def __init__(
        self,
        page: Path,
        folder: Path,
        environment: Mapping[str, str],
        forks: Optional[Forks] = None,
    ) -> None:
        self._page = page
        self._folder = folder
        self._shell = Shell(folder, environment, forks)
        self._names: Dict[str, Any] = {"__name__": "__main__"}
        self._written: List[str] = []

    def run(self) -> None:
        """Runs all blocks.

        Raises:
            PageError: with the page's line.
        """
        try:
            with _inside(self._folder):
                for block in blocks_of(self._page):
                    self._run_block(block)
            self._load_files()
        finally:
            self._shell.close()

    def _run_block(self, block: Block) -> None:
        other = block.note("with the files of:")
        if other:
            for each in blocks_of(self._page.parent / other):
                if each.file:
                    self._write(each)
        need = block.need
        if block.note("not run:") or (need and importlib.util.find_spec(need) is None):
            return
        source = block.note("part of:")
        if source:
            self._compare(block, source)
        elif block.file:
            self._write(block)
        elif block.language == "python":
            self._run_python(block)
        elif block.language == "console":
            self._run_console(block)
        elif block.language != SHOWN:
            message = f'a reason to leave this "{block.language}" block out'
            raise self._error(block, f"expected the name of a file, or {message}")

    def _write(self, block: Block) -> None:
        path = self._folder / block.file
        path.parent.mkdir(parents=True, exist_ok=True)
        if block.is_addition and block.file not in self._written:
            raise self._error(block, f"the page has no file {block.file} yet")
        text = block.text if path.suffix in (".py", ".yaml") else FILE.sub("", block.text)
        with path.open("a" if block.is_addition else "w", encoding="utf-8") as file:
            file.write(text)
        self._written.append(block.file)

    def _compare(self, block: Block, source: str) -> None:
        """Compares an excerpt with its file, named from the repository's folder."""
        if block.text not in (ROOT / source).read_text(encoding="utf-8"):
            raise self._error(block, f"{source} has no such part")

    def _run_python(self, block: Block) -> None:
        source = "\n" * (block.line - 1) + block.text
        try:
            exec(compile(source, str(self._page), "exec"), self._names)
        except (Exception, SystemExit):
            raise self._error(block, traceback.format_exc()) from None

    def _run_console(self, block: Block) -> None:
        if block.note("prints then"):
            found = self._shell.wait_for(block.text)
            if found is not None:
                raise self._difference(block, Command("the last program", block.text), found)
            return
        commands = commands_of(block.text)
        instead = block.note("instead:")
        if instead:
            commands = [commands[0]._replace(text=instead), *commands[1:]]
        for command in commands[:-1]:
            self._run_command(block, command, 0)
        last = commands[-1]
        if block.note("runs on"):
            found = self._shell.start(last.text, last.output)
            if found is not None:
                raise self._difference(block, last, found)
        else:
            self._run_command(block, last, int(block.note("ends with") or 0))

    def _run_command(self, block: Block, command: Command, code: int) -> None:
        try:
            printed, ended_with = self._shell.run(command.text)
        except subprocess.TimeoutExpired as error:
            raise self._error(
                block, f"$ {command.text}\ntook more than {error.timeout} s"
            ) from None
        found = without_colors(printed)
        if ended_with != code:
            raise self._error(
                block, f"$ {command.text}\nended with {ended_with}, not {code}:\n{found}"
            )
        if not pattern_of(command.output).match(found if found.endswith("\n") else f"{found}\n"):
            raise self._difference(block, command, found)

    def _load_files(self) -> None:
        """Loads what is a world, a model or a map; but not with plugins that are the page's own."""
        classes = re.findall(r"^class (\w+)\((?:Model|World)Plugin", self._text(), re.MULTILINE)
        with contextlib.closing(YamlPreprocessor()) as preprocessor:
            for name in dict.fromkeys(self._written):
                path = self._folder / name
                if path.suffix == ".yaml" and _is_loadable(path, classes):
                    try:
                        load(path, preprocessor)
                    except FlatlandError as error:
                        raise PageError(f"{self._page}: {name}: {error}") from None

    def _text(self) -> str:
        return "".join(path.read_text() for path in self._folder.rglob("*.py"))

    def _difference(self, block: Block, command: Command, found: str) -> PageError:
        shown = command.output or "nothing"
        return self._error(block, f"$ {command.text}\nthe page shows\n{shown}\nand it is\n{found}")

    def _error(self, block: Block, message: str) -> PageError:
        return PageError(f"{self._page}:{block.line}: {message}")


def _is_loadable(path: Path, classes: Sequence[str]) -> bool:
    text = path.read_text(encoding="utf-8")
    if any(re.search(rf"\b{name}\b|model: \w+", text) for name in classes):
        return False
    return any(f"\n{key}:" in f"\n{text}" for key in ("bodies", "layers", "origin"))


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """In this folder, with its modules importable, and none of them left in memory afterwards."""
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
