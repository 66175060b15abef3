"""roslaunch, with an exit code and a quiet Ctrl-C.

roslaunch ends with 0 whatever became of its nodes. This takes the same arguments, does the same,
and ends with the exit code of the node marked `required="true"` that brought the launch down.
"""

import signal
import sys


def end(_signal=None, _frame=None):
    """End well; a second Ctrl-C while Python shuts down must not leave a traceback."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.exit(0)


# For Ctrl-C while roslaunch is loading; its own handler, later, stops the nodes and calls this one.
signal.signal(signal.SIGINT, end)

import roslaunch.parent  # noqa: E402
from roslaunch.pmon import ProcessListener  # noqa: E402


class Launch(roslaunch.parent.ROSLaunchParent, ProcessListener):
    """A launch that remembers how a required node ended."""

    exit_code = 0  # of the class, since roslaunch.main keeps the object to itself

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
        if exit_code and self.pm.get_process(process_name).required:
            Launch.exit_code = exit_code if exit_code > 0 else 128 - exit_code  # as a shell has it


roslaunch.parent.ROSLaunchParent = Launch
try:
    roslaunch.main(sys.argv)
finally:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
sys.exit(Launch.exit_code)
