"""The errors of flatland_server's services, for display."""

import re

_CLASS_NAME = re.compile(r"[A-Za-z_]+Error: ")


def error_text(message: str) -> str:
    """The `message` of a response without its leading exception class.

    The class is for programs: "ModelError: there is no model" becomes "there is no model".
    """
    match = _CLASS_NAME.match(message)
    return message[match.end() :] if match else message
