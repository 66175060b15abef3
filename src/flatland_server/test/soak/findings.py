"""Findings of a soak: counts of actions, and violations of requirements."""

import contextlib
from collections import Counter
from typing import Any, Dict, Iterator, List
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

    def to_dict(self) -> Dict[str, Any]:
        return {"counts": dict(sorted(self.counts.items())), "violations": self.violations}
