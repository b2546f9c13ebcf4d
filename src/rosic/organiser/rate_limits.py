"""How much a person, a robot and a role may be asked for: token buckets that outlive a restart.

Each line costs its author one; an order that is permitted costs what its skill says: its author
the rest of it, its robot, and the roles under which it is given all of it. A command to a group
costs its author and roles as one, and each of its robots for itself. Nobody who may not command a
robot takes anything from its bucket.

**What is promised over a restart.** Buckets that are not full are saved every `SAVE_EVERY_S` while
anything is taken, and at the end of a run; what was saved goes on filling while ROSIC is down. The
first taking after a save is marked on the record, before the claim of the order it belongs to.
After a crash, if there is no such mark, every bucket comes back as it was. If there is one, what
was taken since is not known: then every bucket counts as empty at the latest time at which it can
have been taken from, two such intervals after the mark or the start, whichever is earlier. So no
restart, clean or not, ever gives more than the limit; after a crash it may give less, for at most
the time in which a bucket fills. (A wall clock set forward while ROSIC is down gives up to one
burst too much; set back, it gives nothing.)
"""

from __future__ import annotations

import logging
from math import ceil
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import said
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.records import Fact
from rosic.core.time_units import HOUR_S
from rosic.errors import TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.i18n import Sentence
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId

_LONG_S, _LONGER_S = 120, 7_200


def person_full(wait_s: float) -> TooManyRequests:
    """Return the refusal of somebody's own limit."""
    sentence = said("That is more than one person may ask. Again in {wait}.", wait=_wait(wait_s))
    return TooManyRequests(sentence, retry_after_s=wait_s)


def robot_full(shown: str, wait_s: float) -> TooManyRequests:
    """Return the refusal of a robot's limit."""
    sentence = said(
        "{robot} has had as many commands as it takes, from everybody together. "
        "Nothing was done. Again in {wait}.",
        robot=shown,
        wait=_wait(wait_s),
    )
    return TooManyRequests(sentence, retry_after_s=wait_s, own=False)


def role_full(role: str, wait_s: float) -> TooManyRequests:
    """Return the refusal of a role's limit."""
    sentence = said(
        "Your role has asked for as much as it may: everybody who is {role}, together. "
        "Nothing was done. Again in {wait}.",
        role=role,
        wait=_wait(wait_s),
    )
    return TooManyRequests(sentence, retry_after_s=wait_s, own=False)


def _wait(wait_s: float) -> Sentence:
    """Return how long, never less than it is."""
    if wait_s <= _LONG_S:
        return said("{n} s", n=max(1, ceil(wait_s - 1e-9)))
    if wait_s <= _LONGER_S:
        return said("{n} min", n=ceil(wait_s / 60))
    return said("{n} h", n=ceil(wait_s / HOUR_S))


KIND: Final = "rate"
FILL: Final = "fill"
OPEN: Final = "open"
SAVE_EVERY_S: Final = 10.0

PERSON, ROBOT, ROLE = "person", "robot", "role"

log = logging.getLogger("rosic.organiser")


class BucketFill(msgspec.Struct, frozen=True):
    """The body of the fact: what is missing in the buckets that are not full, at one time.

    Attributes:
        at_ns: Wall clock.
        missing: Of whom, and how many tokens.
    """

    at_ns: int
    missing: tuple[tuple[str, str, float], ...] = ()


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(BucketFill).decode


class RateLimits:
    """Every bucket that is not full.

    Attributes:
        person: The limit of each person.
        robots: The limits of robots that have one, each for everybody together.

    Args:
        roles: The limits of roles at the start, each for everybody who acts under it: what was
            left of them goes on filling.
        note: Keeps facts, soon and in order with everything else that is written.
        shown_of: How a robot is shown.
    """

    def __init__(
        self,
        clock: Clock,
        person: RateLimit,
        robots: Mapping[RobotId, RateLimit],
        roles: Mapping[str, RateLimit],
        note: Callable[[Fact], None],
        shown_of: Callable[[RobotId], str],
    ) -> None:
        self.person = person
        self.robots = dict(robots)
        self._roles = roles
        self._note, self._shown_of = note, shown_of
        self._clock = clock
        self._people: dict[PrincipalId, Bucket] = {}
        self._others: dict[tuple[str, str], Bucket] = {}
        self._unsaved = False
        self._empty_ns: int | None = None  # monotonic: everything counts as empty then

    def add_robot(self, robot: RobotId, limit: RateLimit) -> None:
        """Limit one more robot from now on."""
        self.robots[robot] = limit

    # ---- for each order ----

    def enter(self, principal: PrincipalId, now_ns: int) -> float:
        """Take one from somebody's bucket. Return 0.0, or the seconds until there is one."""
        bucket = self._people.get(principal)
        if bucket is None:
            bucket = self._people[principal] = self._bucket(self.person, now_ns)
        if not self._unsaved:
            self._mark()
        return bucket.take(now_ns)

    def spend(
        self,
        principal: PrincipalId,
        cost: float,
        robots: Iterable[tuple[RobotId, float]],
        roles: Mapping[str, RateLimit],
    ) -> TooManyRequests | None:
        """Take what permitted orders cost, wholly or not at all; return why not.

        Args:
            principal: Who asks; one was taken from them already.
            cost: What it costs them and their roles.
            robots: What it costs each robot.
            roles: Under which the orders are given, as far as they have a limit; it is the one in
                force now.
        """
        now_ns = self._clock.monotonic_ns()
        wanted: list[tuple[str, str, Bucket, float]] = []
        if cost > 1:
            own = self._people.get(principal)
            if own is None:
                own = self._people[principal] = self._bucket(self.person, now_ns)
            wanted.append((PERSON, principal, own, cost - 1))
        limited = [(ROBOT, r, limit, c) for r, c in robots if (limit := self.robots.get(r))]
        limited += [(ROLE, role, limit, cost) for role, limit in roles.items()]
        wanted += [
            (k, name, self._other(k, name, limit, now_ns), c) for k, name, limit, c in limited
        ]
        takes = [(b, min(c, b.limit.burst - (kind == PERSON))) for kind, _, b, c in wanted]
        for (kind, name, _, _), (bucket, price) in zip(wanted, takes, strict=True):
            wait_s = bucket.wait_s(now_ns, price)
            if wait_s:
                return self._refusal(kind, name, wait_s)
        for bucket, price in takes:
            bucket.take(now_ns, price)
        if takes and not self._unsaved:
            self._mark()
        return None

    def _other(self, kind: str, name: str, limit: RateLimit, now_ns: int) -> Bucket:
        bucket = self._others.get((kind, name))
        if bucket is None:
            bucket = self._others[kind, name] = self._bucket(limit, now_ns)
        return bucket

    def _bucket(self, limit: RateLimit, now_ns: int) -> Bucket:
        """Make a bucket for somebody who has none: it is full, unless a crash left that open."""
        if self._empty_ns is None:
            return Bucket(limit, now_ns)
        return Bucket(limit, now_ns, (now_ns - self._empty_ns) / 1e9 * limit.per_s)

    def _refusal(self, kind: str, name: str, wait_s: float) -> TooManyRequests:
        if kind == PERSON:
            return person_full(wait_s)
        return (
            robot_full(self._shown_of(name), wait_s) if kind == ROBOT else role_full(name, wait_s)
        )

    # ---- over a restart ----

    def _mark(self) -> None:
        self._unsaved = True
        self._note(Fact(kind=KIND, key=OPEN, body=_encode(BucketFill(self._clock.wall_ns()))))

    def save(self) -> tuple[Fact, ...]:
        """Return what is to be written now, in one; nothing if nothing was taken since the last.

        Buckets that are full are let go: this looks at those that were used lately.
        """
        if not self._unsaved:
            return ()
        self._unsaved = False
        now_ns = self._clock.monotonic_ns()
        missing: list[tuple[str, str, float]] = []
        for who, bucket in tuple(self._people.items()):
            lacks = bucket.missing(now_ns)
            if lacks > 0:
                missing.append((PERSON, who, lacks))
            else:
                del self._people[who]
        for (kind, name), bucket in tuple(self._others.items()):
            lacks = bucket.missing(now_ns)
            if lacks > 0:
                missing.append((kind, name, lacks))
            else:
                del self._others[kind, name]
        body = _encode(BucketFill(self._clock.wall_ns(), tuple(missing)))
        return (
            Fact(kind=KIND, key=FILL, body=body),
            Fact(kind=KIND, key=OPEN, body=b""),
        )

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what the last run left. What cannot be read counts as empty buckets."""
        now_ns, wall_ns = self._clock.monotonic_ns(), self._clock.wall_ns()
        saved: BucketFill | None = None
        for fact in facts:
            try:
                read = _decode(fact.body) if fact.body else None
            except msgspec.MsgspecError:
                log.warning("how much of the rate limits was used cannot be read; all count as so")
                read = BucketFill(wall_ns)
                self._empty_ns = now_ns
            if fact.key == FILL:
                saved = read
            elif read is not None and self._empty_ns is None:
                emptied_ns = read.at_ns + int(2 * SAVE_EVERY_S * 1e9)
                self._empty_ns = now_ns - max(0, wall_ns - emptied_ns)
        if self._empty_ns is None and saved is not None:
            self._fill(saved, now_ns, max(0, wall_ns - saved.at_ns) / 1e9)

    def _limit(self, kind: str, name: str) -> RateLimit | None:
        if kind == PERSON:
            return self.person
        return (self.robots if kind == ROBOT else self._roles).get(name)

    def _fill(self, saved: BucketFill, now_ns: int, passed_s: float) -> None:
        for kind, name, lacks in saved.missing:
            limit = self._limit(kind, name)
            if limit is None:
                continue
            bucket = Bucket(limit, now_ns, limit.burst - lacks + passed_s * limit.per_s)
            if kind == PERSON:
                self._people[name] = bucket
            else:
                self._others[kind, name] = bucket
