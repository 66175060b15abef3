"""Runs the command `flatland`: python -m flatland2d."""

import sys

from flatland2d.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
