"""A soak of bridges: clients misbehave in rounds, and honest ones beside them go on being served."""

import random
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Callable, Dict, List, Sequence

from soak.bridge_misdeeds import Misdeeds, restore
from soak.bridge_process import LIMIT, Bridge, serve, start_node
from soak.bridge_witnesses import Witness, witnesses
from soak.findings import Findings
from soak.random_bridge_messages import PLANTED
from soak.usage import Usage
from waiting import wait_until

STARTS: Dict[str, Callable[[ExitStack, Path, Path], Bridge]] = {
    "serve": serve,
    "bridge": start_node,
}
MOST_PEAK = 300.0
"""What clients may take of the memory for a moment [MB]: eight at their limits, decoded."""
AT_START = 2.0
"""How long files and threads are counted at first [s]: the node asks its master from time to time."""
MOST_MEMORY = 3000.0  # MB: a bridge with more is killed, before the machine suffers


class BridgeSoak:
    """One kind of bridge, which is started again after a fault that ends it.

    Args:
        kind: one of `STARTS`.
        folder: of logs and files.
        findings: what was found.
    """

    def __init__(self, kind: str, folder: Path, findings: Findings) -> None:
        self._kind = kind
        self._folder = folder
        self._findings = findings
        self._planted = folder / "planted"
        self._planted.mkdir(parents=True)
        self._proof = folder / "imported"
        text = f"open({str(self._proof)!r}, 'w').close()\n"
        (self._planted / f"{PLANTED}.py").write_text(text)
        self._processes = ExitStack()
        self._witnesses: List[Witness] = []
        self._start()

    @property
    def bridge(self) -> Bridge:
        """The bridge that runs."""
        return self._bridge

    def run_round(self, seed: int, names: Sequence[str] = ()) -> None:
        """Tries the misdeeds of some names, or all, and looks at the bridge after each of them."""
        for name in names or Misdeeds(self._bridge, random.Random(), self._findings, "").all:
            what = f"seed {seed}, {self._kind}, {name}"
            rng = random.Random(f"{name} {seed}")
            misdeeds = Misdeeds(self._bridge, rng, self._findings, what)
            self._findings.counts[f"misdeeds to {self._kind}"] += 1
            self._bridge.forget_peak()
            before = self._bridge.usage().memory
            begin = time.monotonic()
            ended = threading.Event()
            guard = threading.Thread(target=self._guard, args=(ended,), daemon=True)
            guard.start()
            try:
                misdeeds.all[name]()
                restore(self._bridge)
            except (OSError, AssertionError) as error:
                self._findings.expect(False, f"{what}: {error!r}")
            finally:
                ended.set()
                guard.join()
            is_sound = self._check(what, before, time.monotonic() - begin)
            if not is_sound:
                self.close()
                self._start()

    def close(self) -> None:
        """Ends all processes."""
        for each in self._witnesses:
            each.close()
        self._processes.close()

    def _start(self) -> None:
        self._processes = ExitStack()
        self._bridge = STARTS[self._kind](self._processes, self._folder, self._planted)
        self._witnesses = witnesses(self._bridge)
        warm_up = Misdeeds(self._bridge, random.Random(0), self._findings, "warm-up")
        before = self._bridge.usage().open_files
        warm_up.many_calls()
        wait_until(lambda: self._bridge.usage().open_files <= before + 5, "connections to end")
        self._bridge.empty_log()
        self._at_start = Usage.largest(self._bridge.process.pid, AT_START)

    def _guard(self, ended: threading.Event) -> None:
        """Kills a bridge that takes the machine's memory."""
        while not ended.wait(0.05):
            try:
                if self._bridge.usage().memory > MOST_MEMORY:
                    self._bridge.process.kill()
            except OSError:
                return

    def _check(self, what: str, before: float, seconds: float) -> bool:
        """Looks at the bridge after a misdeed. Returns whether it is as before."""
        bridge, findings, count = self._bridge, self._findings, self._findings.counts
        faults = count["violations"]
        log = bridge.log
        where = log.find("Traceback")
        findings.expect(where < 0, f"{what}: traceback: {log[max(0, where - 200) :][:3000]}")
        findings.expect(not self._proof.exists(), f"{what}: a client has imported a module")
        self._proof.unlink(missing_ok=True)
        bridge.empty_log()
        if not findings.expect(bridge.is_running, f"{what}: the bridge has ended: {log[-2000:]}"):
            return False
        peak = bridge.peak() - before
        findings.expect(peak < MOST_PEAK, f"{what}: {peak:.0f} MB were taken in {seconds:.1f} s")
        for each in self._witnesses:
            each.check(findings, what)
        now = time.monotonic()
        missing = lambda: [topic for each in self._witnesses for topic in each.missing(now)]
        if not _comes(lambda: not missing()):
            findings.expect(False, f"{what}: honest clients get nothing on {missing()}")
        if not _comes(lambda: bridge.usage().has_no_more_than(self._at_start)):
            usage = bridge.usage()
            findings.expect(False, f"{what}: {usage} has not gone back to {self._at_start}")
        return count["violations"] == faults

    def usage(self) -> Usage:
        return self._bridge.usage()


def _comes(holds: Callable[[], bool]) -> bool:
    """Whether a condition holds soon."""
    try:
        return wait_until(holds, "", 2 * LIMIT)
    except AssertionError:
        return False
