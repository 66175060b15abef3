"""The command line of scripts/soak."""

import argparse
import json
import signal
import sys
import tempfile
from pathlib import Path

from soak.bridge_soak import soak_bridges
from soak.random_sweeps import soak_sweeps
from soak.soak import Soak


def _report(line: str) -> None:
    print(line, flush=True)


def main() -> int:
    """Runs a soak. Returns the exit code: 1 if something that must hold did not."""
    parser = argparse.ArgumentParser(prog="soak", description="Disturb a server for a long time.")
    parser.add_argument("--minutes", type=float, default=10.0, help="how long (default 10)")
    parser.add_argument("--clients", type=int, default=4, help="of the services (default 4)")
    parser.add_argument("--seed", type=int, default=0, help="of the first round (default 0)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to a file")
    parser.add_argument("--sweeps", action="store_true", help="disturb sweeps alone, no server")
    parser.add_argument("--bridges", action="store_true", help="disturb bridges alone")
    options = parser.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM):  # the processes that it has started end too
        signal.signal(number, lambda *_: sys.exit(130))
    with tempfile.TemporaryDirectory(prefix="flatland_soak_") as folder:
        if options.sweeps or options.bridges:
            soak_part = soak_sweeps if options.sweeps else soak_bridges
            figures = soak_part(Path(folder), 60.0 * options.minutes, options.seed, _report)
        else:
            soak = Soak(Path(folder), options.clients, options.seed)
            figures = soak.run(60.0 * options.minutes, _report)
    text = json.dumps(figures, indent=2)
    print(text)
    if options.json:
        options.json.write_text(text + "\n", encoding="utf-8")
    return 1 if figures["violations"] else 0


if __name__ == "__main__":
    sys.exit(main())
