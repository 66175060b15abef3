#!/usr/bin/python3
"""Starts the window many times under Xvfb, and reports the starts that ended in a crash.

    src/flatland_viz/test/window_starts.py [--starts 300] [--at-once 2] [--seconds 1] [--cores DIR]
        [--rviz] [--busy 12]
        [--launch flatland_server server.launch world_path:=FILE use_rviz:=true]

Run it with ROS's environment (`source devel/setup.bash`). Each window gets SIGINT after its first
second on the screen, and must end with exit code 0. The exit code of this program says whether all
did. Without `--launch`, no server runs: a crash such as that of `window_ids.py` is in the first
frames, whatever they show. `--busy` programs share one core with all of it. `--rviz` starts plain
rviz, as tests do, instead of the window.
"""

import argparse
import collections
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

sys.path.append(str(Path(__file__).resolve().parents[2] / "flatland_server" / "test"))

from plain_rviz import plain_rviz
from ros_processes import executable, free_port

CONFIG = Path(__file__).resolve().parents[1] / "rviz" / "flatland.rviz"
LIMIT = 60.0  # s: for a window to appear, and to end


class Start:
    """One window, from its start to its end.

    Args:
        command: the window's command.
        number: of the start; part of the node's name.
        environment: with the display and the master.
        seconds: how long the window is on the screen.
        folder: the working directory, where core files are written.
    """

    def __init__(
        self,
        command: List[str],
        number: int,
        environment: Dict[str, str],
        seconds: float,
        folder: Path,
    ):
        self.number = number
        self._environment = environment
        self._seconds = seconds
        self._begin = time.monotonic()
        self._shown: Optional[float] = None
        self._interrupted: Optional[float] = None
        self.process = subprocess.Popen(
            [*command, f"__name:=window_{number}"],
            env=environment,
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )

    def advance(self) -> Optional[str]:
        """Takes the next step if it is due. Returns the outcome once the start has ended."""
        code = self.process.poll()
        now = time.monotonic()
        if code is not None:
            if code == 0 and self._interrupted is not None:
                return "ended as asked"
            return f"exit code {code} {'after SIGINT' if self._interrupted else 'by itself'}"
        if now - (self._interrupted or self._begin) > LIMIT:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
            return f"no {'end' if self._interrupted else 'window'} within {LIMIT:g} s"
        if self._shown is None:
            if self._is_visible():
                self._shown = now
        elif self._interrupted is None and now - self._shown >= self._seconds:
            os.killpg(self.process.pid, signal.SIGINT)
            self._interrupted = now
        return None

    def _is_visible(self) -> bool:
        search = ["xdotool", "search", "--onlyvisible", "--pid", str(self.process.pid)]
        # xdotool ends with an X error if another window is closed meanwhile: look again later.
        return bool(subprocess.run(search, env=self._environment, capture_output=True).stdout)


def _start_busy(number: int) -> List["subprocess.Popen[bytes]"]:
    """Starts programs that take all time of one core, which whatever starts later shares."""
    if number:
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    return [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(number)]


def _start_screen() -> Tuple["subprocess.Popen[bytes]", str]:
    """Starts an X server. Returns it and the name of the display."""
    read, write = os.pipe()
    screen = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "1400x900x24", "-noreset"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    with os.fdopen(read) as pipe:
        return screen, f":{pipe.readline().strip()}"


def _start_launch(words: List[str], port: int, environment: Dict[str, str]) -> Any:
    """Starts a ROS master, and whatever a launch file starts; returns once simulated time runs."""
    quiet = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    if not words:
        return subprocess.Popen(["rosmaster", "--core", "-p", str(port)], **quiet)
    launch = subprocess.Popen(["roslaunch", "-p", str(port), *words], **quiet)
    echo = ["rostopic", "echo", "-n", "1", "/clock"]
    while subprocess.run(echo, **quiet).returncode != 0:  # there is no master yet
        assert launch.poll() is None, f"roslaunch has ended: {' '.join(words)}"
    return launch


def run(options: argparse.Namespace) -> Dict[str, int]:
    """Starts windows, and returns the number of starts by outcome."""
    busy = _start_busy(options.busy)
    screen, display = _start_screen()
    port = free_port()
    environment = {
        **os.environ,
        "DISPLAY": display,
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "XDG_CONFIG_HOME": str(options.cores / "config"),
    }
    command = [executable("flatland_viz", "flatland_viz")]
    if options.rviz:
        command = [*plain_rviz(options.cores), "-d", str(CONFIG)]
    launch = _start_launch(options.launch, port, environment)
    ends: Dict[str, int] = collections.Counter()
    running: List[Start] = []
    number = 0
    try:
        while number < options.starts or running:
            while number < options.starts and len(running) < options.at_once:
                number += 1
                running.append(Start(command, number, environment, options.seconds, options.cores))
            time.sleep(0.05)
            for start in list(running):
                end = start.advance()
                if end is not None:
                    running.remove(start)
                    ends[end] += 1
                    if end != "ended as asked":
                        print(
                            f"start {start.number}, process {start.process.pid}: {end}", flush=True
                        )
    finally:
        for start in running:
            os.killpg(start.process.pid, signal.SIGKILL)
        for program in (launch, *busy):
            program.terminate()
            program.wait()
        screen.terminate()
    return ends


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--starts", type=int, default=300, help="how many (300)")
    parser.add_argument("--at-once", type=int, default=2, help="how many at a time (2)")
    parser.add_argument("--seconds", type=float, default=1.0, help="each on the screen (1)")
    parser.add_argument("--cores", type=Path, default=Path.cwd(), help="folder for core files")
    parser.add_argument("--rviz", action="store_true", help="plain rviz instead of the window")
    parser.add_argument("--busy", type=int, default=0, help="programs that share a core (0)")
    parser.add_argument("--launch", nargs="+", default=[], help="roslaunch with these arguments")
    options = parser.parse_args()
    begin = time.monotonic()
    ends = run(options)
    for end, count in sorted(ends.items()):
        print(f"{count:5d} {end}")
    print(f"in {time.monotonic() - begin:.0f} s")
    return 0 if set(ends) <= {"ended as asked"} else 1


if __name__ == "__main__":
    sys.exit(main())
