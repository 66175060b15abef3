"""Changes to the world that must wait until they are safe.

Plugins may spawn, move and delete models and change footprints in any hook. Box2D allows no such
change during a step, though, and a model cannot be deleted while its plugins are being started or
stopped. These changes are deferred: kept as actions, in the order of the requests, and run once the
world is free again.
"""

import logging
from collections import deque
from contextlib import contextmanager
from typing import Any, Callable, ContextManager, Deque, Iterator, Optional, Set, Tuple, TypeVar

from flatland_server.exceptions import FlatlandError

logger = logging.getLogger(__name__)

R = TypeVar("R")

MAX_ACTIONS_PER_RUN = 1000
"""The limit of one `run_pending`, in case that each action causes another one."""


class DeferredActions:
    """Runs actions at once if that is safe, and later if not.

    Actions are deferred in two cases:

    - within `lock`: all of them. The world is locked during a step, while bodies are removed
      (which calls the `end_contact` hooks of other models) and while the world is closed.
    - within `changing(model)`, while the plugins of a model are started or stopped: those that
      cannot be run before this has ended. Others run at once.

    Deferred actions are run by `run_pending`, once neither is the case any more.
    """

    def __init__(self) -> None:
        self.lock = _Lock()
        """A context in which all actions are deferred. May be nested."""
        self.pending: Deque[Tuple[Callable[[], Any], str]] = deque()
        """The deferred actions, each with the log message for a failure."""
        self.revision = 0
        """Counts the actions that were not deferred: changes from outside the steps."""
        self._changing: Set[str] = set()
        self._is_running = False

    @property
    def is_locked(self) -> bool:
        """True if every action would be deferred."""
        return self.lock.depth > 0

    @property
    def defers_nothing(self) -> bool:
        """True if every action would run at once."""
        return not self.lock.depth and not self._changing

    @contextmanager
    def changing(self, model: str) -> Iterator[None]:
        """A context in which this model is started or stopped. May be nested for several models."""
        self._changing.add(model)
        try:
            yield
        finally:
            self._changing.discard(model)

    def run_or_defer(
        self, action: Callable[[], R], failure: str, *, unless_changing: str = ""
    ) -> Optional[R]:
        """Runs an action and the deferred ones that it has caused; or defers it.

        Args:
            action: changes the world. An exception that it raises at once is the caller's; if it
                is deferred, a `FlatlandError` is logged.
            failure: the text of this log message, such as "the world is not reset".
            unless_changing: a model; the action has to wait while this is started or stopped.

        Returns:
            The result of the action; None if it is deferred.
        """
        if self.is_locked or unless_changing in self._changing:
            self.pending.append((action, failure))
            return None
        self.revision += 1
        result = action()
        self.run_pending()
        return result

    def change_shapes(self, action: Callable[[], None], failure: str) -> None:
        """As `run_or_defer`, for an action that ends contacts, which calls hooks.

        Args:
            action: changes shapes.
            failure: as for `run_or_defer`.
        """

        def locked() -> None:
            with self.lock:
                action()

        self.run_or_defer(locked, failure)

    def run_pending(self) -> None:
        """Runs the deferred actions, also those that are deferred meanwhile, if it is safe now.

        At most 1000 of them are run; the others wait for the next call. A call from within an
        action does nothing, since the call that runs this action goes on.
        """
        if not self.pending or self._is_running:
            return
        self._is_running = True
        try:
            for _ in range(MAX_ACTIONS_PER_RUN):
                if not self.pending or self.is_locked or self._changing:
                    return
                action, failure = self.pending.popleft()
                try:
                    action()
                except FlatlandError as error:
                    logger.error("%s: %s", failure, error)
        finally:
            self._is_running = False

    def drop(self, reason: str) -> None:
        """Drops the deferred actions, and logs that they have failed for this reason."""
        while self.pending:
            _, failure = self.pending.popleft()
            logger.error("%s: %s", failure, reason)


class _Lock(ContextManager[None]):
    """A context that may be nested; it counts how deeply. Lean, since every step enters it."""

    __slots__ = ("depth",)

    def __init__(self) -> None:
        self.depth = 0

    def __enter__(self) -> None:
        self.depth += 1

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        self.depth -= 1
