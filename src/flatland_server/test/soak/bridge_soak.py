"""A soak of bridges: clients misbehave in rounds, and honest ones beside them are served."""

import random
import threading
import time
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Sequence

from ros2_environment import DISTRIBUTIONS, is_made
from soak.bridge_misdeeds import MISDEEDS, Misdeeds, restore
from soak.bridge_process import LIMIT, Bridge, serve, serve_ros2, start_node
from soak.bridge_witnesses import witnesses
from soak.findings import Findings
from soak.random_bridge_messages import PLANTED
from soak.usage import MOST_GROWTH, Usage
from waiting import wait_until

STARTS: Dict[str, Callable[[ExitStack, Path, Path], Bridge]] = {
    "serve": serve,
    "bridge": start_node,
    "ros2": serve_ros2,
}
MOST_PEAK = 300.0
"""Memory of clients for a moment [MB]: eight at their limits, decoded."""
SLACK = {"serve": 8, "bridge": 8, "ros2": 58}
"""Files and threads that each may have more than at its start: workers start when needed."""
AT_START = 1.0
"""Time for which files and threads are counted at first [s]: the node asks every 0.5 s."""
MOST_KEPT = 150.0
"""Memory beyond that of the start after a misdeed [MB]: freed, but not given back."""
MOST_MEMORY = 3000.0  # MB: a bridge with more is killed, before the machine suffers


class BridgeSoak:
    """A bridge of one kind, which is started again after a fault.

    Args:
        kind: one of `STARTS`.
        folder: folder for logs and files.
        share: length of misdeeds, relative to the usual one.

    Attributes:
        kind: one of `STARTS`.
    """

    def __init__(self, kind: str, folder: Path, share: float = 1.0) -> None:
        self.kind = kind
        self._folder = folder
        self._share = share
        self._planted = folder / "planted"
        self._planted.mkdir(parents=True)
        self._proof = folder / "imported"
        text = f"open({str(self._proof)!r}, 'w').close()\n"
        (self._planted / f"{PLANTED}.py").write_text(text)
        self._start()

    @property
    def bridge(self) -> Bridge:
        """The bridge that runs."""
        return self._bridge

    def run_round(self, seed: int, names: Sequence[str], findings: Findings) -> None:
        """Tries some of `MISDEEDS`, and looks at the bridge after each of them."""
        for name in names:
            what = f"seed {seed}, {self.kind}, {name}"
            rng = random.Random(f"{name} {seed}")
            misdeeds = Misdeeds(self._bridge, rng, findings, what, self._share)
            findings.counts[f"misdeeds to {self.kind}"] += 1
            violations = findings.counts["violations"]
            try:
                with self._limited_memory(what, findings):
                    getattr(misdeeds, name)()
                    restore(self._bridge)
            except (OSError, AssertionError) as error:
                findings.expect(False, f"{what}: {error!r}")
            self._check(what, findings)
            if findings.counts["violations"] > violations:
                self.close()
                self._start()

    def check_growth(self, findings: Findings) -> None:
        """The memory does not grow after a fifth of the time."""
        count = len(self._memories) // 5
        if count >= len(MISDEEDS):
            warm, end = max(self._memories[:count]), min(self._memories[-count:])
            what = f"{self.kind}: memory has grown from {warm:.1f} to {end:.1f} MB"
            findings.expect(end <= MOST_GROWTH * warm, what)

    def close(self) -> None:
        """Ends all processes."""
        for each in self._witnesses:
            each.close()
        self._processes.close()

    def _start(self) -> None:
        with ExitStack() as processes:
            self._bridge = STARTS[self.kind](processes, self._folder, self._planted)
            self._witnesses = witnesses(self._bridge)
            self._memories: List[float] = []  # after each misdeed
            before = self._bridge.usage().open_files
            Misdeeds(self._bridge, random.Random(), Findings(), "").many_calls()
            wait_until(lambda: self._bridge.usage().open_files <= before + 5, "connections to end")
            self._bridge.empty_log()
            self._at_start = Usage.largest(self._bridge.process.pid, AT_START)
            self._processes = processes.pop_all()

    @contextmanager
    def _limited_memory(self, what: str, findings: Findings) -> Iterator[None]:
        """A context that takes little memory; a bridge that takes the machine's is killed."""
        before, ended = self._bridge.usage().memory, threading.Event()
        self._bridge.forget_peak()
        guard = threading.Thread(target=self._guard, args=(ended,), daemon=True)
        guard.start()
        try:
            yield
        finally:
            ended.set()
            guard.join()
            if self._bridge.is_running:
                taken = self._bridge.peak() - before
                findings.expect(taken < MOST_PEAK, f"{what}: it takes {taken:.0f} MB")

    def _guard(self, ended: threading.Event) -> None:
        """Kills a bridge that takes the machine's memory."""
        while not ended.wait(0.05):
            try:
                if self._bridge.usage().memory > MOST_MEMORY:
                    self._bridge.process.kill()
            except (OSError, KeyError):  # it has ended
                return

    def _check(self, what: str, findings: Findings) -> None:
        """The bridge is as before, and honest clients have been served."""
        bridge, log = self._bridge, self._bridge.log
        where = log.find("Traceback")
        findings.expect(where < 0, f"{what}: {log[max(0, where - 200) :][:3000]}")
        findings.expect(not self._proof.exists(), f"{what}: a client has imported a module")
        self._proof.unlink(missing_ok=True)
        bridge.empty_log()
        if not findings.expect(bridge.is_running, f"{what}: it has ended: {log[-2000:]}"):
            return
        for each in self._witnesses:
            each.check(findings, what)
        kept = bridge.usage().memory - self._at_start.memory
        findings.expect(kept < MOST_KEPT, f"{what}: it has {kept:.0f} MB more than at its start")
        now = time.monotonic()
        if not _comes(lambda: not self._missing(now), 2 * LIMIT):
            missing = self._missing(now)
            findings.expect(False, f"{what}: honest clients get nothing on {missing}")
        start = self._at_start
        slack = SLACK[self.kind]
        most = start._replace(open_files=start.open_files + slack, threads=start.threads + slack)
        if not _comes(lambda: bridge.usage().has_no_more_than(most), 4 * LIMIT):
            usage = bridge.usage()
            findings.expect(False, f"{what}: {usage} has not gone back to {start}")
        self._memories.append(bridge.usage().memory)

    def _missing(self, since: float) -> List[str]:
        return [topic for each in self._witnesses for topic in each.missing(since)]


def soak_bridges(
    folder: Path, seconds: float, seed: int, report: Callable[[str], None]
) -> Dict[str, Any]:
    """Disturbs bridges for a time [s], in one round at least. Returns figures for JSON."""
    findings = Findings()
    bridges = [BridgeSoak(kind, folder / kind) for kind in STARTS if kind != "ros2"]

    def run(each: BridgeSoak, misdeeds: Sequence[str], seed: int) -> None:
        each.run_round(seed, misdeeds, findings)
        usage = each.bridge.usage()
        report(f"{each.kind:8} {usage.memory:.1f} MB, {usage.open_files} files")

    def run_round(seed: int) -> None:
        for each in bridges:
            run(each, MISDEEDS, seed)
        # Only for its misdeed: the witnesses of three servers take all the time of two cores.
        if is_made(DISTRIBUTIONS[0]):
            with closing(BridgeSoak("ros2", folder / f"ros2_{seed}")) as ros2:
                run(ros2, ["ros2_node"], seed)

    try:
        figures = findings.run_rounds(seconds, seed, run_round, report)
        for each in bridges:
            each.check_growth(findings)
        return {**figures, **findings.to_dict()}
    finally:
        for each in bridges:
            each.close()


def _comes(holds: Callable[[], bool], limit: float) -> bool:
    """True if a condition holds within a time [s]."""
    try:
        return wait_until(holds, "", limit)
    except AssertionError:
        return False
