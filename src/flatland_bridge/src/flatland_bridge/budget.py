"""Bytes that are kept for clients: what waits for each, and what is remembered on its behalf."""

import threading
from typing import Callable, Set

ENTRY = 1000
"""Bytes of an entry of a table or queue, besides its content."""

CLIENT_MEMORY = 16_000_000
"""Bytes that are kept for a client, unless its server says otherwise."""

_FULL_BUDGETS = 16
"""All clients together have this many times the bytes of one."""


class Budget:
    """The bytes of one client. Its methods may be called on any thread, and never raise.

    Messages of topics wait in what else leaves free, and are dropped where they do not fit. For
    what cannot be dropped, a client that exceeds its budget has to go.

    Args:
        budgets: the budgets of all clients, to which this one belongs.
        on_excess: called once, with the reason, when the client has to go; on any thread.
    """

    def __init__(self, budgets: "Budgets", on_excess: Callable[[str], None]) -> None:
        self._budgets = budgets
        self._on_excess = on_excess
        self.goes = False
        """True once the client has to go, or is gone."""
        self.held = 0
        """Bytes that cannot be dropped."""
        self.waiting = 0
        """Bytes of messages of topics."""
        self.sending = 0
        """Bytes on their way: one message of any size, beside the client's own limit."""

    @property
    def used(self) -> int:
        """All of its bytes."""
        return self.held + self.waiting + self.sending

    def hold(self, size: int) -> None:
        """Counts something that cannot be dropped.

        Args:
            size: in bytes; negative when it is gone.
        """
        with self._budgets.lock:
            self.held += size
            self._budgets.count(self, size)
            is_over = size > 0 and self.held > self._budgets.limit
        if is_over:
            limit = self._budgets.limit
            self.exceed(
                f"expected at most {limit} bytes for a client, found more (--client-memory)"
            )

    def offer(self, size: int) -> bool:
        """Counts a message of a topic, if it fits; of any size if it is the only one.

        Returns:
            False if it does not fit.
        """
        with self._budgets.lock:
            if self.waiting and self.held + self.waiting + size > self._budgets.limit:
                return False
            self.waiting += size
            self._budgets.count(self, size)
        return True

    def release(self, size: int) -> None:
        """Counts that a message of a topic waits no longer."""
        with self._budgets.lock:
            self.waiting -= size
            if not self.goes:
                self._budgets.total -= size

    def send(self, size: int) -> None:
        """Counts something on its way.

        Args:
            size: in bytes; negative when it is sent.
        """
        with self._budgets.lock:
            self.sending += size
            self._budgets.count(self, size)

    def exceed(self, reason: str) -> None:
        """Makes the client go.

        Args:
            reason: text for the client.
        """
        if self._budgets.discount(self):
            self._on_excess(reason)

    def close(self) -> None:
        """Forgets the client: nothing is kept on its behalf any more."""
        self._budgets.discount(self)
        self._budgets.forget(self)


class Budgets:
    """The budgets of all clients.

    Args:
        limit: of each [bytes].

    Attributes:
        lock: of all counters.
        total: bytes of all clients that stay.
    """

    def __init__(self, limit: float = CLIENT_MEMORY) -> None:
        self.limit = limit
        self.lock = threading.RLock()
        self._most = limit * _FULL_BUDGETS
        self.total = 0
        self._open: Set[Budget] = set()

    def __len__(self) -> int:
        return len(self._open)

    def open(self, on_excess: Callable[[str], None] = lambda reason: None) -> Budget:
        """The budget of a new client.

        Args:
            on_excess: as for `Budget`.
        """
        budget = Budget(self, on_excess)
        with self.lock:
            self._open.add(budget)
        return budget

    def count(self, budget: Budget, size: int) -> None:
        """Counts bytes of a client, with the lock; that with the most goes if there are too many.

        Args:
            budget: the client's budget.
            size: bytes to add.
        """
        if budget.goes:
            return
        self.total += size
        if size > 0 and self.total > self._most:
            largest = max((each for each in self._open if not each.goes), key=lambda e: e.used)
            largest.exceed(f"expected at most {self._most} bytes for all clients, found more")

    def discount(self, budget: Budget) -> bool:
        """Leaves out a client that goes. Returns whether it was counted."""
        with self.lock:
            if budget.goes:
                return False
            budget.goes = True
            self.total -= budget.used
            return True

    def forget(self, budget: Budget) -> None:
        """Makes room for another client."""
        with self.lock:
            self._open.discard(budget)
