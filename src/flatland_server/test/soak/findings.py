"""Findings of a soak: counts of actions, and violations of requirements."""

import contextlib
import time
from collections import Counter
from typing import Any, Callable, Dict, Iterator, List
from typing import Counter as CounterType

MOST = 50  # violations that are kept


class Findings:
    """Counts and violations; threads may share one."""

    def __init__(self) -> None:
        self.counts: CounterType[str] = Counter()
        self.violations: List[str] = []

    def expect(self, condition: Any, what: str) -> bool:
        """Records a violation unless the condition holds. Returns whether it does."""
        if not condition:
            self.counts["violations"] += 1
            if len(self.violations) < MOST:
                self.violations.append(what)
        return bool(condition)

    @contextlib.contextmanager
    def part(self, what: str) -> Iterator[None]:
        """A part of a soak: an exception in it is a violation."""
        self.counts[what] += 1
        try:
            yield
        except Exception as error:
            self.expect(False, f"{what}: {type(error).__name__}: {error}")

    def add(self, values: Dict[str, Any]) -> None:
        """Adds other findings, as given by `to_dict`."""
        self.counts.update(values["counts"])
        self.violations = [*self.violations, *values["violations"]][:MOST]

    def run_rounds(
        self,
        seconds: float,
        seed: int,
        run_round: Callable[[int], None],
        report: Callable[[str], None],
    ) -> Dict[str, Any]:
        """Runs rounds for a time [s], one at least. Returns figures as a dict for JSON.

        Args:
            seconds: time after which no round begins [s].
            seed: the first round's seed.
            run_round: runs a round of a seed.
            report: prints a line.
        """
        begin, rounds, reported = time.monotonic(), 0, 0
        while rounds == 0 or time.monotonic() < begin + seconds:
            run_round(seed + rounds)
            rounds += 1
            minutes = (time.monotonic() - begin) / 60.0
            report(f"{minutes:6.1f} min  round {rounds}  {dict(self.counts)}")
            for violation in self.violations[reported:]:
                report(f"         {violation}")
            reported = len(self.violations)
        total = round(time.monotonic() - begin, 1)
        return {"seconds": total, "rounds": rounds, "seed": seed, **self.to_dict()}

    def to_dict(self) -> Dict[str, Any]:
        return {"counts": dict(sorted(self.counts.items())), "violations": self.violations}
