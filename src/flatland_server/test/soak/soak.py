"""A soak: one server that is disturbed in rounds, and its resources after each of them."""

import contextlib
import random
import time
from pathlib import Path
from typing import Any, Callable, Dict, List

from running_server import Master, Server
from soak import faults, restarts
from soak.bridge_misdeeds import MISDEEDS
from soak.bridge_soak import STARTS, BridgeSoak
from soak.findings import Findings
from soak.in_process import run_in_process
from soak.random_calls import call_at_random
from soak.random_saves import save_at_random
from soak.random_sweeps import disturb_sweeps
from soak.ros_messages import publish_at_random
from soak.usage import MOST_GROWTH, Usage
from waiting import wait_until

CALLS, SAVES, MESSAGES, SIGNALS, KILLS = 100, 100, 50, 2, 3
# of a client, calls around saves, to each topic, to starting servers, of sweeps
REST = 200
"""Equal readings in a row of files and threads, 5 ms apart, for the server to be at rest."""
WARM_UP = 0.2  # of the time
BRIDGE_MISDEEDS = 3  # in a round, to each kind of bridge


class Soak:
    """Runs rounds of disturbances; each has a seed, from `seed` on.

    Args:
        folder: folder for logs and files.
        clients: number of clients that call services at once.
        seed: the first round's seed.
    """

    def __init__(self, folder: Path, clients: int, seed: int) -> None:
        self._folder = folder
        self._clients = clients
        self._seed = seed
        self.findings = Findings()
        self.rounds = 0
        self.start = Usage(0.0, 0, 0)
        """Resources before the first round."""
        self.usages: List[Usage] = []
        """Resources after each round."""
        self._tracebacks = 0

    def run(self, seconds: float, report: Callable[[str], None]) -> Dict[str, Any]:
        """Runs for a time [s], and at least two rounds. Returns the figures as a dict for JSON."""
        begin = time.monotonic()
        warm_rounds = reported = 0
        with contextlib.ExitStack() as processes:
            self._start(processes)
            faults.silent_connections(self._server, random.Random(self._seed), self.findings)
            self.start = self._usage_at_rest()
            while self.rounds < 2 or time.monotonic() < begin + seconds:
                self._run_round()
                if not self._server.is_running:
                    self.findings.expect(False, f"the server has ended: {self._server.log[-3000:]}")
                    break
                self._check_usage()
                self._check_log()
                if warm_rounds == 0 or time.monotonic() < begin + WARM_UP * seconds:
                    warm_rounds = self.rounds
                report(self._line(time.monotonic() - begin))
                for violation in self.findings.violations[reported:]:
                    report(f"         {violation}")
                reported = len(self.findings.violations)
            for bridge in self._bridges:
                bridge.check_growth(self.findings)
        return self.figures(time.monotonic() - begin, warm_rounds)

    def _start(self, processes: contextlib.ExitStack) -> None:
        self._master = Master()
        processes.callback(self._master.kill)
        self._other_master = Master()  # of servers that are killed and started
        processes.callback(self._other_master.kill)
        self._server = Server(self._master, self._folder / "server.log")
        processes.callback(self._server.kill)
        self._bridges = [BridgeSoak(kind, self._folder / kind) for kind in STARTS]
        for bridge in self._bridges:
            processes.callback(bridge.close)

    def _run_round(self) -> None:
        seed = self._seed + self.rounds
        server, master, findings = self._server, self._master, self.findings
        rng = random.Random(f"faults {seed}")
        parts: Dict[str, Callable[[], None]] = {
            "random calls": lambda: call_at_random(
                server, master, seed, self._clients, CALLS, findings
            ),
            "random saves": lambda: save_at_random(
                server, self._folder / f"saves_{seed}", seed, SAVES, findings
            ),
            "random messages": lambda: publish_at_random(server, master, seed, MESSAGES, findings),
            "stopped subscribers": lambda: faults.stopped_subscribers(server, findings),
            "silent connections": lambda: faults.silent_connections(server, rng, findings),
            "lack of descriptors": lambda: faults.no_descriptors(server, findings),
            "dead masters": lambda: faults.dead_master(server, master, findings),
            "random files": lambda: run_in_process(seed, findings),
            "random sweeps": lambda: disturb_sweeps(
                self._folder / f"sweep_{seed}", seed, KILLS, findings
            ),
            "killed servers": lambda: restarts.killed_server(
                self._other_master, self._folder, findings
            ),
            "full disks": lambda: restarts.full_disk(self._other_master, findings),
            "bridges": lambda: self._disturb_bridges(seed, rng),
            "signals": lambda: restarts.signals_at_random(
                self._other_master, self._folder, rng, SIGNALS, findings
            ),
        }
        for name, part in parts.items():
            with findings.part(name):
                part()
            if not server.is_running:
                break
        self.rounds += 1

    def _usage_at_rest(self) -> Usage:
        """The server's resources when the threads of closed connections have ended."""
        usages: List[Usage] = []

        def is_at_rest() -> bool:
            usages.append(Usage.of(self._server.process.pid))
            latest = usages[-REST:]
            return len(latest) == REST and len({usage[1:] for usage in latest}) == 1

        wait_until(is_at_rest, "the server to be at rest")
        return usages[-1]

    def _disturb_bridges(self, seed: int, rng: random.Random) -> None:
        for bridge in self._bridges:
            bridge.run_round(seed, rng.sample(MISDEEDS, BRIDGE_MISDEEDS), self.findings)

    def _check_usage(self) -> None:
        """Records the server's resources: no more files and threads than at the start."""
        pid = self._server.process.pid
        with self.findings.part("comparisons of descriptors and threads"):
            wait_until(
                lambda: Usage.of(pid).has_no_more_than(self.start),
                f"files and threads to be as in {self.start}",
            )
        self.usages.append(Usage.of(pid))

    def _check_log(self) -> None:
        log = self._server.log
        count = log.count("Traceback")
        self._tracebacks += count
        self.findings.expect(not count, f"traceback: {log[log.find('Traceback') :][:3000]}")
        self._server.empty_log()

    def _line(self, seconds: float) -> str:
        usage = self.usages[-1]
        return (
            f"{seconds / 60:6.1f} min  round {self.rounds}  {usage.memory:.1f} MB  "
            f"{usage.open_files} files  {usage.threads} threads  "
            f"{self.findings.counts['calls']} calls  "
            f"{self.findings.counts['violations']} violations"
        )

    def figures(self, seconds: float, warm_rounds: int) -> Dict[str, Any]:
        """The figures after a time [s] as a dict for JSON; memory that has grown is a violation."""
        usages = {"start": self.start._asdict()}
        if self.usages:
            warm = max(usage.memory for usage in self.usages[:warm_rounds])
            end = self.usages[-1]
            usages["after warm-up"] = {**self.usages[warm_rounds - 1]._asdict(), "memory": warm}
            usages["end"] = end._asdict()
            what = f"memory has grown from {warm:.1f} to {end.memory:.1f} MB"
            self.findings.expect(end.memory <= MOST_GROWTH * warm, what)
        return {
            "seconds": round(seconds, 1),
            "rounds": self.rounds,
            "warm-up rounds": warm_rounds,
            "clients": self._clients,
            "seed": self._seed,
            "server": usages,
            "unanswered calls": self.findings.counts["unanswered"],
            "tracebacks": self._tracebacks,
            **self.findings.to_dict(),
        }
