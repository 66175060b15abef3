"""roslaunch, with an exit code, a quiet Ctrl-C, and errors as the last lines.

roslaunch ends with 0 even if a node has failed. This takes the same arguments, does the same,
and ends with the exit code of the node marked `required="true"` that brought the launch down. If
that has refused to start, with exit code 1, roslaunch prints nothing more, so that the node's
message stays in view. Arguments, the port and the ROS master are checked before anything starts.
"""

import argparse
import atexit
import gc
import http.client
import os
import re
import signal
import socket
import sys
import xmlrpc.client
from pathlib import Path


def end(_signal=None, _frame=None):
    """Exits; a second Ctrl-C while Python shuts down must not leave a traceback."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(0)


# For Ctrl-C while roslaunch is loading; its own handler, later, stops the nodes and calls this one.
signal.signal(signal.SIGINT, end)
gc.disable()  # imports leave little garbage, and collections take a sixth of their time

import rosgraph  # noqa: E402
import roslaunch.core  # noqa: E402
import roslaunch.launch  # noqa: E402
import roslaunch.nodeprocess  # noqa: E402
import roslaunch.parent  # noqa: E402
import roslaunch.pmon  # noqa: E402
import rospkg  # noqa: E402
from roslaunch.pmon import ProcessListener  # noqa: E402

from flatland_server.exceptions import FlatlandError  # noqa: E402
from flatland_server.ros.launch_arguments import check_launch_arguments  # noqa: E402

SERVER = "flatland_server"
WINDOW = "flatland_viz"
OPEN_AGAIN = "source devel/setup.bash; rosrun flatland_viz flatland_viz"
_LIMIT = 3.0  # s, for an answer
_REFUSED = re.compile(r"REQUIRED process .*exit code 1,", re.DOTALL)


class Launch(roslaunch.parent.ROSLaunchParent, ProcessListener):
    """A launch that remembers how a required node ended."""

    exit_code = 0  # of the class: roslaunch.main does not return the object

    def _load_config(self):
        # Launch files run commands (rosversion), which would answer Ctrl-C with a traceback.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        super()._load_config()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

    def _start_pm(self):
        # Not by the argument `process_listeners`: those are added after the nodes have started.
        super()._start_pm()
        self.pm.add_process_listener(self)

    def process_died(self, process_name, exit_code):
        if exit_code and process_name.startswith(WINDOW):
            print(f"run: the window has ended; the simulation goes on. Open it again: {OPEN_AGAIN}")
        if exit_code and self.pm.get_process(process_name).required:
            Launch.exit_code = exit_code if exit_code > 0 else 128 - exit_code  # as a shell has it


class Output:
    """Silences roslaunch once a required node has refused to start."""

    def __init__(self):
        self._is_over = False

    def install(self):
        modules = (roslaunch.core, roslaunch.launch, roslaunch.nodeprocess)
        for module in (*modules, roslaunch.parent, roslaunch.pmon):
            for name in ("printlog", "printlog_bold", "printerrlog"):
                if hasattr(module, name):
                    setattr(module, name, self._until_refused(getattr(module, name)))

    def _until_refused(self, print_line):
        def print_or_not(message):
            self._is_over = self._is_over or bool(_REFUSED.search(message))
            if not self._is_over:
                print_line(message)

        return print_or_not


def problem(words):
    """The reason to refuse a launch with these arguments, or None."""
    try:
        files = [Path(word) for word in words if word.endswith(".launch") and "/" in word]
        server = Path(rospkg.RosPack().get_path(SERVER), "launch", "server.launch")
        check_launch_arguments(files or [server], words)
    except FlatlandError as error:
        return str(error)
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("-p", "--port", type=int)
    port = parser.parse_known_args(words)[0].port
    uri = f"http://localhost:{port}" if port else rosgraph.get_master_uri()
    return problem_of_master(uri, port)


def problem_of_master(uri, port):
    """The reason against a new simulation with the ROS master at a URI, or None.

    Args:
        uri: of the master, which may not run yet.
        port: the number after `-p`, if there is one: for a master of the launch's own.
    """
    host, number = rosgraph.network.parse_http_host_and_port(uri)
    if not is_open(host, number):
        return None
    socket.setdefaulttimeout(_LIMIT)
    try:
        master = xmlrpc.client.ServerProxy(uri)
        if not answers(master):
            return f"port {number} is taken by a program that is no ROS master: choose one by -p"
        if port and master.hasParam("/run", "/run_id")[2]:
            return (
                f"port {port} has the ROS master of another run: choose another port, or leave out "
                f"-p and set ROS_MASTER_URI={uri} to join it"
            )
        name = rosgraph.names.ns_join(os.environ.get("ROS_NAMESPACE", "/"), SERVER)
        code, _, node = master.lookupNode("/run", rosgraph.names.make_global_ns(name).rstrip("/"))
        if code == 1 and answers(xmlrpc.client.ServerProxy(node)):
            return (
                f"a simulation is running at {uri}: end it, or give this one a ROS master of its "
                f"own, by -p {number + 1}"
            )
    finally:
        socket.setdefaulttimeout(None)
    return None


def answers(node):
    """True if a ROS master or node answers."""
    try:
        return node.getPid("/run")[0] == 1
    except (OSError, ValueError, http.client.HTTPException, xmlrpc.client.Error):
        return False


def is_open(host, port):
    """True if a program listens at a port."""
    try:
        with socket.create_connection((host, port), timeout=_LIMIT):
            return True
    except OSError:
        return False


gc.freeze()
gc.enable()
atexit.register(gc.freeze)  # skips the collection at exit
reason = problem(sys.argv[1:])
if reason:
    print(f"run: {reason}", file=sys.stderr)
    sys.exit(1)
roslaunch.parent.ROSLaunchParent = Launch
Output().install()
try:
    roslaunch.main(sys.argv)
finally:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
sys.exit(Launch.exit_code)
