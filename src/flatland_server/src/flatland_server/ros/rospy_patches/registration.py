"""Registers this node's topics and services with the ROS master, on a thread of its own.

rospy calls the master for each topic, on the thread that opens or closes it, and waits for the
answer: with a thousand robots, that takes longer than the rest of loading the world. If the master
is stopped or gone, that thread waits forever; here it would be the simulation's.

A `Registrar` collects what is opened and closed, and registers or unregisters many in one call. If
the master does not answer, it tries again. If the master has been restarted, so that it does not
know this node any more, it registers everything again.
"""

import logging
import threading
from contextlib import contextmanager, suppress
from itertools import islice
from typing import Any, Callable, Dict, Iterator, List

import rospy
import rospy.core
from rospy.impl.paramserver import get_param_server_cache
from rospy.impl.registration import (
    Registration,
    RegistrationListener,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)
from rospy.impl.statistics import SubscriberStatisticsLogger

from flatland_server.ros.rospy_patches.master_calls import NO_ANSWER, Change, Key, Master
from flatland_server.ros.rospy_patches.rospy_checks import Requirement, check_all

_MODULE = "rospy.impl.registration"
_CHANGE = ("self", "resolved_name", "data_type_or_uri", "reg_type")

REQUIREMENTS = (
    Requirement(f"{_MODULE}:get_registration_listeners", ()),
    Requirement(f"{_MODULE}:get_topic_manager", ()),
    Requirement(f"{_MODULE}:get_service_manager", ()),
    Requirement(f"{_MODULE}:RegistrationListeners.__init__", uses=("listeners", "lock")),
    Requirement(f"{_MODULE}:RegistrationListener.reg_added", _CHANGE),
    Requirement(f"{_MODULE}:RegistrationListener.reg_removed", _CHANGE),
    Requirement(f"{_MODULE}:RegManager.__init__", uses=("uri", "master_uri")),
    Requirement(f"{_MODULE}:RegManager.publisher_update", ("self", "resolved_name", "uris")),
    Requirement(f"{_MODULE}:Registration.PUB"),
    Requirement(f"{_MODULE}:Registration.SUB"),
    Requirement(f"{_MODULE}:Registration.SRV"),
    Requirement("rospy.core:is_shutdown_requested", ()),
    Requirement("rospy:get_param_cached", ("param_name", "default")),
    Requirement("rospy.impl.paramserver:get_param_server_cache", ()),
    Requirement("rospy.impl.statistics:SubscriberStatisticsLogger.is_enabled", ()),
    Requirement("rospy.topics:_TopicManager.get_publications", ("self",)),
    Requirement("rospy.topics:_TopicManager.get_subscriptions", ("self",)),
    Requirement("rospy.service:ServiceManager.get_services", ("self",)),
)

CHECK_PERIOD = 3.0
"""Real time between checks that the master still knows this node [s]."""
RETRY_PERIOD = 0.5
"""Real time after which a call that was not answered is repeated [s]."""
_END_LIMIT = 1.0  # s
_ROSOUT_TOPICS = "/rosout_disable_topics_generation"
_BATCH = 500  # topics and services per call: a master takes some 0.1 s for them
_REOPENED = ""
"""Stands for the type of a topic that the master knows and that has to be registered again."""

logger = logging.getLogger(__name__)


def install() -> Dict[str, Any]:
    """Puts a registrar in rospy's place. Returns the calls that this replaces.

    Raises:
        UnknownRospyError: this rospy is not known, or the node is not initialised.
    """
    check_all(REQUIREMENTS)
    _keep_parameters()
    listeners = get_registration_listeners()
    with listeners.lock:
        managers = [each for each in listeners.listeners if hasattr(each, "publisher_update")]
        if len(managers) != 1:  # no node, as in tests of single modules
            return {}
        registrar = Registrar(managers[0], Master(managers[0].master_uri))
        registrar.take_over(_opened_so_far())
        listeners.listeners = [registrar]
    registrar.start()
    rospy.on_shutdown(registrar.stop)
    return {
        "batch_registration": registrar.batch,
        "wait_until_registered": registrar.wait_until_done,
    }


def _keep_parameters() -> None:
    """Caches parameters that rospy reads from the master at each subscription and each log."""
    is_enabled = SubscriberStatisticsLogger.is_enabled()
    SubscriberStatisticsLogger.is_enabled = classmethod(lambda cls: is_enabled)
    # rospy does not cache that a parameter is not set. The master notifies this node if it is set.
    with suppress(OSError):
        value = rospy.get_param_cached(_ROSOUT_TOPICS, False)
        get_param_server_cache().set(_ROSOUT_TOPICS, value)


def _opened_so_far() -> Dict[Key, str]:
    opened = {}
    for kind, entries in (
        (Registration.PUB, get_topic_manager().get_publications()),
        (Registration.SUB, get_topic_manager().get_subscriptions()),
        (Registration.SRV, get_service_manager().get_services()),
    ):
        opened.update({(kind, name): detail for name, detail in entries})
    return opened


class Registrar(RegistrationListener):  # type: ignore[misc]
    """Keeps the master's registrations in line with the open topics and services.

    Args:
        manager: rospy's RegManager, which connects subscriptions to publishers.
        master: calls to the ROS master.
        is_ending: true while the node shuts down.
    """

    def __init__(
        self,
        manager: Any,
        master: Master,
        is_ending: Callable[[], bool] = rospy.core.is_shutdown_requested,
    ) -> None:
        self._manager = manager
        self._master = master
        self._is_ending = is_ending
        self._open: Dict[Key, str] = {}
        self._known: Dict[Key, str] = {}
        self._changed: Dict[Key, None] = {}  # a set that keeps its order
        self._batches = 0
        self._is_busy = False
        self._has_ended = False
        self._has_failed = False
        self._condition = threading.Condition()

    def take_over(self, opened: Dict[Key, str]) -> None:
        """Records the topics and services that are open and registered already."""
        self._open.update(opened)
        self._known.update(opened)

    def start(self) -> None:
        """Starts the thread that makes the calls."""
        threading.Thread(target=self._run, name="registrar", daemon=True).start()

    def stop(self) -> None:
        """Ends the thread, so that rospy can unregister what is still open.

        Before, closed topics and services are unregistered, if the master answers. rospy calls this
        when its shutdown has begun.
        """
        with self._condition:
            self._condition.wait_for(lambda: not self._changed or self._has_failed, _END_LIMIT)
            self._has_ended = True
            self._condition.notify_all()
            self._condition.wait_for(lambda: not self._is_busy, 0.1)

    def reg_added(self, name: str, detail: str, kind: str) -> None:
        with self._condition:
            self._open[kind, name] = detail
            if kind == Registration.SUB and (kind, name) in self._known:
                # Closed, and not unregistered yet. The new subscriber needs the list of publishers,
                # which is the answer to a registration.
                self._known[kind, name] = _REOPENED
            self._note((kind, name))

    def reg_removed(self, name: str, detail: str, kind: str) -> None:
        with self._condition:
            self._open.pop((kind, name), None)
            self._note((kind, name))

    def _note(self, key: Key) -> None:
        self._changed[key] = None
        if not self._batches:
            self._condition.notify_all()

    @contextmanager
    def batch(self) -> Iterator[None]:
        """A context at the end of which all changes are registered together."""
        with self._condition:
            self._batches += 1
        try:
            yield
        finally:
            with self._condition:
                self._batches -= 1
                self._condition.notify_all()

    def wait_until_done(self, limit: float) -> bool:
        """Waits until the master knows everything that is open, at most `limit` [s].

        Returns at once if the master does not answer.

        Returns:
            Whether it knows everything.
        """
        with self._condition:
            self._condition.wait_for(lambda: not self._changed or self._has_failed, limit)
            return not self._changed

    def _run(self) -> None:
        while not self._has_ended:
            with self._condition:
                self._condition.wait_for(self._is_due, CHECK_PERIOD)
                changes = self._next_changes()
                self._is_busy = True
            try:
                if changes:
                    self._apply(changes)
                else:
                    self._check()
                self._note_answer()
            except NO_ANSWER as error:
                self._note_silence(error)
            finally:
                with self._condition:
                    self._is_busy = False
                    self._condition.notify_all()
            if self._has_failed:
                with self._condition:
                    self._condition.wait_for(lambda: self._has_ended, RETRY_PERIOD)

    def _is_due(self) -> bool:
        return self._has_ended or bool(self._changed and not self._batches)

    def _next_changes(self) -> List[Change]:
        """The next changes to register; `_changed` keeps them until that is done."""
        if self._batches or self._has_ended:
            return []
        changes = []
        for key in list(islice(self._changed, _BATCH)):
            if self._open.get(key) == self._known.get(key):  # the master knows it already
                del self._changed[key]
            elif key in self._open:
                changes.append(Change(True, *key, self._open[key]))
            else:
                changes.append(Change(False, *key, self._known[key]))
        if not self._changed:
            self._condition.notify_all()
        return changes

    def _apply(self, changes: List[Change]) -> None:
        answers = self._master.apply(changes, self._manager.uri)
        with self._condition:
            for change in changes:
                key = change.kind, change.name
                if change.is_open:
                    self._known[key] = change.detail
                else:
                    self._known.pop(key, None)
                if self._open.get(key) == self._known.get(key):
                    self._changed.pop(key, None)
            self._condition.notify_all()
        for change, (code, status, value) in zip(changes, answers):
            if not change.is_open:
                continue
            if code != 1:
                logger.error("the master refuses %s: %s", change.name, status)
            elif change.kind == Registration.SUB and value:
                self._manager.publisher_update(change.name, value)

    def _check(self) -> None:
        """Registers everything again if the master does not know a service of this node any more.

        rospy's own services are registered before anything else, and never closed.
        """
        with self._condition:
            services = (
                (name, uri) for (kind, name), uri in self._known.items() if kind == Registration.SRV
            )
            name, uri = next(services, ("", ""))
        if self._has_ended or not name or self._master.has_service(name, uri):
            return
        with self._condition:
            self._known.clear()
            self._changed.update(dict.fromkeys(self._open))
            count = len(self._open)
        logger.warning("the master was restarted: registering %d topics and services again", count)

    def _note_answer(self) -> None:
        if self._has_failed:
            logger.info("the master answers again")
        self._has_failed = False

    def _note_silence(self, error: Exception) -> None:
        if not self._has_failed and not self._is_ending():
            logger.error(
                "the master at %s does not answer (%s): topics are registered when it does",
                self._master.uri,
                error,
            )
        self._has_failed = True
