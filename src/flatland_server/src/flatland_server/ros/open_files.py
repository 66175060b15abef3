"""The process's limit of open files, for connections, and for topics if rospy is not patched."""

import logging
import resource

ENOUGH = 65536
"""The number of open files to ask for; the usual soft limit is 1,024."""
_FEW = 4096

logger = logging.getLogger(__name__)


def raise_limit() -> None:
    """Raises the soft limit of open files as far as the hard limit allows; warns if that is low.

    Each subscriber needs a connection, which is an open file: a recorder of a thousand robots needs
    some thousands.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    limit = ENOUGH if hard == resource.RLIM_INFINITY else min(hard, ENOUGH)
    if soft == resource.RLIM_INFINITY or soft >= limit:
        limit = soft
    else:
        resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
    if limit != resource.RLIM_INFINITY and limit < _FEW:
        logger.warning(
            "at most %d open files (ulimit -Hn): too few for many robots with many subscribers",
            limit,
        )
