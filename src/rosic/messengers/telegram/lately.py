"""What was said in groups in the last minute, over a restart: Telegram counts on meanwhile.

Kept in the record, by a digest of the group, at most as many times as its limit has messages.
"""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING

import msgspec

from rosic.core.identity import DIGEST_BYTES
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Keep


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(tuple[int, ...]).decode

log = logging.getLogger("rosic.messengers.telegram")


class RecentGroupMessages:
    """When something was said in each group, as far as it still counts.

    Args:
        clock: The monotonic one measures; the wall clock runs on over a restart.
        span_s: So long it counts.
    """

    def __init__(self, clock: Clock, span_s: float) -> None:
        self._clock = clock
        self._span_ns = int(span_s * SECOND_NS)
        self._before: dict[str, tuple[int, ...]] = {}
        self._keep: Keep | None = None

    def restore(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        """Take over what an earlier run kept, and have kept what is said from now on."""
        self._keep = keep
        now_ns = self._clock.wall_ns()
        for digest, body in kept.items():
            try:
                said_ns = _decode(body)
            except msgspec.MsgspecError:
                log.warning("what was said in a group lately cannot be read, and counts as nothing")
                said_ns = ()
            # By a clock that was set back, what was said is still to come: it counts from now.
            counts = tuple(min(at, now_ns) for at in said_ns if at + self._span_ns > now_ns)
            if counts:
                self._before[digest] = counts
            else:
                keep(digest, b"")

    def take(self, group: str) -> Iterable[int]:
        """Return when an earlier run said something in a group, on the monotonic clock; once."""
        apart_ns = self._clock.wall_ns() - self._clock.monotonic_ns()
        return [at - apart_ns for at in self._before.pop(_digest(group), ())]

    def note(self, group: str, said_ns: Iterable[int]) -> None:
        """Keep when something was said in a group, on the monotonic clock."""
        if self._keep is not None:
            apart_ns = self._clock.wall_ns() - self._clock.monotonic_ns()
            self._keep(_digest(group), _encode([at + apart_ns for at in said_ns]))


def _digest(group: str) -> str:
    return blake2b(group.encode(), digest_size=DIGEST_BYTES).hexdigest()
