"""Runs the command `flatland`: python -m flatland_server."""

import sys

from flatland_server.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
