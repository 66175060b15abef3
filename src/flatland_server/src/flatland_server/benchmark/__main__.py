"""What `python -m flatland_server.benchmark` runs."""

import sys

from flatland_server.benchmark.command import main

if __name__ == "__main__":
    sys.exit(main())
