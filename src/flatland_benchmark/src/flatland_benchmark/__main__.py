"""Entry point of `python -m flatland_benchmark`."""

import sys

from flatland_benchmark.command import main

if __name__ == "__main__":
    sys.exit(main())
