"""Runs Python programs in forks of a process that has imported what they need.

rostopic, roslaunch or flatland spend half a second on imports before they do anything, and the
guide has dozens of such commands. A fork has the modules already. Its folder, environment,
arguments, output and signals are its own.

usage: forks.py SOCKET    the process that forks, until its input ends
"""

import atexit
import contextlib
import gc
import importlib
import json
import os
import re
import runpy
import select
import shlex
import shutil
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Iterator, List, Mapping, Optional, Sequence

IMPORTED = (
    "encodings.idna",
    "flatland_msgs.srv",
    "flatland_plugins.diff_drive",
    "flatland_plugins.laser",
    "flatland_plugins.model_tf_publisher",
    "flatland2d.cli",
    "flatland2d.simulation",
    "PIL.ImageOps",
    "PIL.PngImagePlugin",
    "nav_msgs.msg",
    "pytest",
    "rosbag",
    "roslaunch",
    "rosservice",
    "rostopic",
    "sensor_msgs.msg",
)
_KIND = socket.AF_UNIX, socket.SOCK_SEQPACKET
_LARGEST = 2**20  # of a message [bytes]
_QUOTED = re.compile(r"'[^']*'|\"[^\"$`\\]*\"")
_VARIABLE = re.compile(r"\$(\w+)")
_PLAIN = re.compile(r"[\w\s./:=,+%@-]*")
_SCRIPT = re.compile(rb"#! ?/usr/bin/(?:env )?python3\n")


def python_words(command: str, environment: Mapping[str, str]) -> Optional[List[str]]:
    """The words of a command of a shell that does nothing but start a Python program.

    Args:
        command: as it is typed.
        environment: of the shell.

    Returns:
        The program's file and its arguments, or "-m", a module and its arguments; None if the
        command is another one, or has a pipe or anything else that is left to the shell.
    """
    command = command.replace("\\\n", " ")
    if "'" not in command:
        command = _VARIABLE.sub(lambda match: environment.get(match[1], match[0]), command)
    if not _PLAIN.fullmatch(_QUOTED.sub("", command)):
        return None
    program, *words = shlex.split(command)
    if program == "python3":
        return words if words[0] == "-m" or not words[0].startswith("-") else None
    file = shutil.which(program, path=environment["PATH"])
    if file is None or not _SCRIPT.match(Path(file).read_bytes()[:40]):
        return None
    return [file, *words]


class Program:
    """A program in a fork; `pid`, `poll` and `wait` are those of `subprocess.Popen`.

    Args:
        connection: to the process that waits for it.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._code: Optional[int] = None
        self.pid = int(connection.recv(_LARGEST))

    def poll(self) -> Optional[int]:
        """The exit code; None while the program runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self.wait(0.0)
        return None

    def wait(self, timeout: float) -> int:
        """Waits for the end, and returns the exit code.

        Raises:
            subprocess.TimeoutExpired: it takes longer than the timeout [s].
        """
        if self._code is None:
            if not select.select([self._connection], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(str(self.pid), timeout)
            self._code = int(self._connection.recv(_LARGEST))
            self._connection.close()
        return self._code


class Forks:
    """Starts programs in forks.

    Args:
        socket: of the process that forks; see `running_forks`.

    Attributes:
        socket: the same.
    """

    def __init__(self, socket: str) -> None:
        self.socket = socket

    def start(
        self, words: Sequence[str], folder: Path, environment: Mapping[str, str], output: Path
    ) -> Program:
        """Starts a program, the leader of a new session.

        Args:
            words: see `python_words`.
            folder: in which it starts.
            environment: its variables.
            output: the file that it prints into, errors included.
        """
        request = [list(words), str(folder), dict(environment), str(output)]
        connection = socket.socket(*_KIND)
        connection.connect(self.socket)
        connection.send(json.dumps(request).encode())
        return Program(connection)


@contextlib.contextmanager
def running_forks(
    *command: str, environment: Optional[Mapping[str, str]] = None
) -> Iterator[Forks]:
    """Runs a process that forks; programs that still run at the end go on.

    Args:
        command: which starts it, and gets its socket; by default this module.
        environment: its variables, by default those of this process.
    """
    with tempfile.TemporaryDirectory() as folder:
        socket = str(Path(folder, "socket"))
        process = subprocess.Popen(
            [*(command or (sys.executable, __file__)), socket],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for the programs, not for this process
        )
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield Forks(socket)
        finally:
            process.stdin.close()
            process.wait()


def _serve(path: str) -> List[str]:
    """Forks for each request, until the input ends.

    Returns:
        In each fork, the words of its program.
    """
    listener = socket.socket(*_KIND)
    listener.bind(path)
    listener.listen()
    print("ready", flush=True)
    while True:
        has_ended = sys.stdin in select.select([sys.stdin, listener], [], [])[0]
        _reap()
        if has_ended:
            sys.exit()
        connection, _ = listener.accept()
        with connection:
            request = json.loads(connection.recv(_LARGEST))
            if os.fork() == 0:
                listener.close()
                return _in_a_fork(connection, *request)


def _reap() -> None:
    """Collects ended child processes and their processor time."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _in_a_fork(
    connection: socket.socket,
    words: List[str],
    folder: str,
    environment: Mapping[str, str],
    output: str,
) -> List[str]:
    """Forks once more: for the program, which this process waits for."""
    pid = os.fork()
    _connect_streams(os.devnull if pid else output)
    if pid:
        status = os.waitpid(pid, 0)[1]
        code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
        connection.send(str(code).encode())
        os._exit(0)
    os.setsid()
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    connection.send(str(os.getpid()).encode())
    connection.close()
    return words


def _connect_streams(output: str) -> None:
    """Connects the standard streams: the input is empty, the others write into a file."""
    reading = os.open(os.devnull, os.O_RDONLY)
    writing = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for source, target in ((reading, 0), (writing, 1), (writing, 2)):
        os.dup2(source, target)
    os.close(reading)
    os.close(writing)


def _run(words: List[str], path: List[str], ending: "_Ending") -> None:
    """Runs a program as Python's command line does.

    Args:
        words: see `python_words`.
        path: the folders of modules, without those of PYTHONPATH.
        ending: called with the exit code.
    """
    is_module = words[0] == "-m"
    first = os.getcwd() if is_module else os.path.dirname(os.path.realpath(words[0]))
    sys.path[:] = [first, *_python_path(), *path]
    sys.argv[:] = words[is_module:]
    try:
        if is_module:
            runpy.run_module(words[1], run_name="__main__", alter_sys=True)
        else:
            runpy.run_path(words[0], run_name="__main__")
        ending.code = 0
    except SystemExit as end:
        ending.code = end.code if isinstance(end.code, int) else int(end.code is not None)
        raise


class _Ending:
    """Ends a fork after all that Python does at exit, but does not free its objects.

    That would copy the memory that it shares, which takes longer than most programs.

    Attributes:
        code: the exit code; None of a program that ends otherwise, by an exception.
    """

    def __init__(self) -> None:
        self.code: Optional[int] = None
        atexit.register(self._end)  # before those of the modules: it is called last

    def _end(self) -> None:
        if self.code is not None:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(self.code)


def _python_path() -> List[str]:
    return [folder for folder in os.environ.get("PYTHONPATH", "").split(os.pathsep) if folder]


if __name__ == "__main__":
    _own = [folder for folder in sys.path[1:] if folder not in _python_path()]
    _ending = _Ending()
    for _name in IMPORTED:
        with contextlib.suppress(ImportError):
            importlib.import_module(_name)
    gc.freeze()  # the collector would copy the memory of each fork, at the latest when it ends
    _run(_serve(sys.argv[1]), _own, _ending)
