"""Commands that tests run to their end."""

import subprocess

import pytest

LIMIT = 600.0
"""Real time of a command, unless a test says otherwise [s]."""


def run(*command, timeout=LIMIT, **options):
    """The output of a command; if it fails, so does the test, with its output.

    Args:
        command: the program and its arguments.
        timeout: real time [s]; None is any.
        options: of `subprocess.run`, such as `env`.
    """
    words = [str(word) for word in command]
    result = subprocess.run(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=timeout,
        **options,
    )
    if result.returncode != 0:
        code = result.returncode
        pytest.fail(f"{' '.join(words)}: exit code {code}\n{result.stdout}", pytrace=False)
    return result.stdout
