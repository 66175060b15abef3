"""Shell sessions as pages show them: commands after `$ `, and below each what it prints."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path
from typing import List, Mapping, NamedTuple, Optional, Tuple

LIMIT = 60.0
"""How long a command may take, and a program to print what it prints at its start [s]."""


class Command(NamedTuple):
    """A command, and what it prints; `...` stands for anything."""

    text: str
    output: str


def commands_of(block: str) -> List[Command]:
    """The commands of a block; one goes on in the next line after a backslash or a quote."""
    commands: List[Command] = []
    text, output = "", []
    for line in block.splitlines():
        if line.startswith("$ "):
            if text:
                commands.append(Command(text, "\n".join(output)))
            text, output = line[2:], []
        elif not output and _goes_on(text):
            text += f"\n{line}"
        else:
            output.append(line)
    return [*commands, Command(text, "\n".join(output))]


def _goes_on(text: str) -> bool:
    is_open = any(text.replace("\\" + quote, "").count(quote) % 2 for quote in "\"'")
    return text.endswith("\\") or is_open


def pattern_of(output: str, is_start: bool = False) -> "re.Pattern[str]":
    """The expression for what is shown: `...` is anything, a line of it alone any lines."""
    pattern = ""
    for line in output.splitlines():
        if line.strip() == "...":
            pattern += r"(?:[^\n]*\n)*?"
        else:
            pattern += (
                r"[^\n]*?".join(re.escape(part.rstrip()) for part in _parts(line)) + r"[ \t]*\n"
            )
    return re.compile(pattern if is_start else rf"\A{pattern}\s*\Z")


def _parts(line: str) -> List[str]:
    return line.rstrip().split("...")


class Shell:
    """A bash that keeps its folder and variables from one command to the next.

    Args:
        folder: where it begins.
        environment: its variables.
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder = folder
        self._environment = dict(environment)
        self._programs: List[Tuple[subprocess.Popen, Path]] = []

    def run(self, command: str) -> "subprocess.CompletedProcess[str]":
        """Runs a command to its end; what it prints is in `stdout`, errors included."""
        state = self._folder / ".shell"
        script = f"{command}\n_code=$?; export -p > {state}.env; pwd > {state}.pwd; exit $_code"
        result = subprocess.run(
            ["bash", "-c", f"{self._restored(state)}{script}"],
            cwd=self._folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LIMIT,
            check=False,
        )
        return result

    def start(self, command: str, output: str) -> Optional[str]:
        """Starts a program that goes on, and waits until it has printed what is shown.

        Returns:
            None, or what it has printed if that is something else.
        """
        state = self._folder / ".shell"
        log = self._folder / f".program{len(self._programs)}.log"
        with log.open("w") as file:
            program = subprocess.Popen(
                ["bash", "-c", f"{self._restored(state)}exec {command}"],
                cwd=self._folder,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )
        self._programs.append((program, log))
        return self.wait_for(output)

    def wait_for(self, output: str) -> Optional[str]:
        """Waits until the program that was started last has printed what is shown; see `start`."""
        program, log = self._programs[-1]
        pattern, deadline = pattern_of(output, is_start=True), time.monotonic() + LIMIT
        while True:
            has_ended = program.poll() is not None
            text = without_colors(log.read_text())
            if pattern.search(text):
                return None
            if has_ended or time.monotonic() > deadline:
                return text
            time.sleep(0.02)

    def close(self) -> None:
        """Ends the programs that were started, as Ctrl-C does, the last one first."""
        for program, _ in reversed(self._programs):
            for number, limit in ((signal.SIGINT, 20.0), (signal.SIGKILL, 5.0)):
                if program.poll() is None:
                    os.killpg(program.pid, number)
                    try:
                        program.wait(limit)
                    except subprocess.TimeoutExpired:
                        continue

    @staticmethod
    def _restored(state: Path) -> str:
        if not Path(f"{state}.env").exists():
            return ""
        return f'source {state}.env; cd "$(cat {state}.pwd)"\n'


def without_colors(text: str) -> str:
    """A text without the escape sequences of terminals."""
    return re.sub(r"\x1b(?:\[[0-9;?]*[A-Za-z]|\][^\x07]*\x07)", "", text)
