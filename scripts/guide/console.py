"""A shell in which the commands of pages run, and expressions for what they print."""

import os
import re
import shlex
import signal
import subprocess
import time
from pathlib import Path
from typing import List, Mapping, Optional, Tuple

LIMIT = 60.0
"""Limit for a command, and for a program's first output [s]."""
_KILLED = 5.0  # s: limit for the end of a killed program


def commands_of(block: str) -> List[str]:
    """The commands of a block; one goes on in the next line after a backslash or a quote."""
    commands: List[str] = []
    for line in block.splitlines():
        if commands and _goes_on(commands[-1]):
            commands[-1] += f"\n{line}"
        else:
            commands.append(line)
    return commands


def _goes_on(text: str) -> bool:
    return text.endswith("\\") or any(
        text.replace("\\" + quote, "").count(quote) % 2 for quote in "\"'"
    )


def pattern_of(output: str, is_start: bool = False) -> "re.Pattern[str]":
    """The pattern of an output block: `...` matches any text; alone on a line, any lines."""
    pattern = ""
    for line in output.splitlines():
        if line.strip() == "...":
            pattern += r"(?:[^\n]*\n)*?"
        else:
            parts = (re.escape(part.rstrip()) for part in line.rstrip().split("..."))
            pattern += r"[^\n]*?".join(parts) + r"[ \t]*\n"
    return re.compile(pattern if is_start else rf"\A{pattern}\s*\Z")


class Shell:
    """A bash that keeps its folder and variables from one command to the next.

    Args:
        folder: working directory at the start.
        environment: environment variables at the start.
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder = folder  # of the files that it needs
        self._current = folder
        self._environment = dict(environment)
        self._programs: List[Tuple[subprocess.Popen[bytes], Path]] = []

    def run(self, command: str) -> Tuple[str, int]:
        """Runs a command to its end.

        Returns:
            What it prints, errors included, and its exit code.

        Raises:
            subprocess.TimeoutExpired: it takes too long.
        """
        output = self._folder / ".output"
        state = self._folder / ".shell"
        keep = f"env -0 > {shlex.quote(f'{state}.env')}; pwd > {shlex.quote(f'{state}.pwd')}"
        program = self._start(f"{command}\n_code=$?; {keep}; exit $_code", output)
        try:
            code = program.wait(LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(program.pid, signal.SIGKILL)
            program.wait(_KILLED)
            raise
        if Path(f"{state}.pwd").exists():
            variables = Path(f"{state}.env").read_text().rstrip("\0").split("\0")
            self._environment = dict(each.split("=", 1) for each in variables)
            self._current = Path(Path(f"{state}.pwd").read_text().rstrip("\n"))
        return output.read_text(), code

    def start(self, command: str, output: str) -> Optional[str]:
        """Starts a program that goes on, and waits until it has printed what is shown.

        Returns:
            None, or what it has printed if that is something else.
        """
        log = self._folder / f".program{len(self._programs)}.log"
        self._programs.append((self._start(f"exec {command}", log), log))
        return self.wait_for(output)

    def _start(self, script: str, output: Path) -> "subprocess.Popen[bytes]":
        """Starts a script in bash."""
        with output.open("w") as file:
            return subprocess.Popen(
                ["bash", "-c", script],
                cwd=self._current,
                env=self._environment,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            )

    def wait_for(self, output: str) -> Optional[str]:
        """Waits until the program that was started last has printed what is shown; see `start`."""
        program, log = self._programs[-1]
        pattern, deadline = pattern_of(output, is_start=True), time.monotonic() + LIMIT
        size = -1
        while True:
            has_ended = program.poll() is not None
            is_over = has_ended or time.monotonic() > deadline
            if log.stat().st_size != size:
                size = log.stat().st_size
                text = without_colors(log.read_text())
                if pattern.search(text):
                    return None
            if is_over:
                return text
            time.sleep(0.02)

    def close(self) -> None:
        """Ends the programs that were started, as Ctrl-C does, the last one first."""
        for program, _ in reversed(self._programs):
            for number, limit in ((signal.SIGINT, 20.0), (signal.SIGKILL, _KILLED)):
                if program.poll() is None:
                    os.killpg(program.pid, number)
                    try:
                        program.wait(limit)
                    except subprocess.TimeoutExpired:
                        continue


def without_colors(text: str) -> str:
    """A string without the escape sequences of terminals."""
    return re.sub(r"\x1b(?:\[[0-9;?]*[A-Za-z]|\][^\x07]*\x07)", "", text)
