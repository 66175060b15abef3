"""Finds the plugin that a thread is running, from its stack, without extra cost for each call."""

from types import FrameType
from typing import Optional

from flatland_server.plugins.plugin import Plugin


def running_plugin(frame: Optional[FrameType]) -> Optional[Plugin]:
    """The plugin that is called innermost on a stack; None if there is none."""
    while frame is not None:
        code, local = frame.f_code, frame.f_locals
        # The first parameter, usually self; and `plugin` in the plugin manager.
        for name in (*code.co_varnames[: min(code.co_argcount, 1)], "plugin"):
            value = local.get(name)
            if isinstance(value, Plugin):
                return value
        frame = frame.f_back
    return None


def describe_running(frame: Optional[FrameType]) -> str:
    """The plugin (if any) and the line of code that a thread is running, for logs."""
    if frame is None:
        return "unknown code"
    place = f"{frame.f_code.co_filename}:{frame.f_lineno}, in {frame.f_code.co_name}"
    plugin = running_plugin(frame)
    return f'the plugin "{plugin.node.owner}" ({place})' if plugin is not None else place
