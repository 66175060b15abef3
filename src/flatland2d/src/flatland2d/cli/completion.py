"""`flatland --print-completion SHELL`: completion of the command line, by shtab."""

import argparse
from typing import Any

from flatland_server.exceptions import needed_module

SHELLS = ("bash", "zsh")

FILES = {"bash": "_shtab_compgen_files", "zsh": "_files"}
"""As the attribute `complete` of an argument: it is completed by names of files."""


class PrintCompletion(argparse.Action):
    """Prints a script for a shell, and ends the process."""

    def __call__(self, parser: argparse.ArgumentParser, *arguments: Any, **_: Any) -> None:
        """Prints the script for the shell that the option names."""
        install = "pip install shtab, or apt install python3-shtab"
        shtab = needed_module("shtab", "completion needs shtab", install)
        print(shtab.complete(parser, shell=arguments[1]))
        parser.exit()
