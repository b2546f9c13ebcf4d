"""What must hold on the log of a whole history; each rule by the name of its invariant."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING

from rosic.core.message import MessageValidity
from rosic.core.order import OrderEnding
from rosic.core.records import Claimed, Concluded, Refused
from tests.gateway.events import Acted, Kept, Latched, Revoked, Said, Started, Unlatched, Written
from tests.gateway.histories import ROBOTS, cids_of

if TYPE_CHECKING:
    from tests.gateway.events import Event
    from tests.gateway.histories import World

MOVERS = {"Ada", "Bo", "Hal"}
WATCHERS = {"Vi"}
SWARM = {"cf1", "cf2"}
QUESTIONS = {"use", "status", "resume"}


def judge(world: World) -> None:
    """Look at a whole history.

    Raises:
        AssertionError: An invariant does not hold; the message begins with its name.
    """
    log = world.log
    at_most_once(log)
    ordered_and_fenced(log)
    stops_dominate(log)
    outcomes_are_honest(log)
    numbers_only_grow(log)
    every_actuation_has_its_message(log)


def at_most_once(log: list[Event]) -> None:
    """I1, and I9: a command acts once; a line acts only by what was written down at once."""
    claims: dict[bytes, int] = {}
    acted: set[bytes] = set()
    line_of: dict[bytes, tuple[int, int]] = {}
    batch_of: dict[tuple[int, int], int] = {}
    for at, event in enumerate(log):
        if isinstance(event, Said):
            line_of.update({cid: (at, line) for cid, line in cids_of(event).items()})
        elif isinstance(event, Written):
            claims.update({r.cid: at for r in event.records if isinstance(r, Claimed)})
        elif isinstance(event, Acted):
            assert event.cid not in acted, f"I1: acted twice: {event}"
            assert event.cid in claims, f"I9: not on disk when it acted: {event}"
            acted.add(event.cid)
            batch, line = claims[event.cid], line_of.get(event.cid)
            if line is not None:
                assert batch_of.setdefault(line, batch) == batch, f"I1: the line acts anew: {event}"


def ordered_and_fenced(log: list[Event]) -> None:
    """I3, I4, I12: numbers grow, fences never fall, one holder under each, one order at a time."""
    n: Counter[str] = Counter()
    fences: Counter[str] = Counter()
    durable: Counter[str] = Counter()
    holders: dict[tuple[str, int], str] = {}
    claimed: dict[bytes, Claimed] = {}
    for event in log:
        if isinstance(event, Written):
            for record in event.records:
                if isinstance(record, Claimed):
                    claimed[record.cid] = record
                    durable[record.robot] = max(durable[record.robot], record.fence)
        elif isinstance(event, Acted):
            robot = event.robot
            assert not event.overlaps, f"I12: two at a time: {event}"
            assert event.n > n[robot], f"I3: {event}"
            n[robot] = event.n
            if event.actuates:
                assert event.fence >= fences[robot], f"I4: {event}"
                assert event.fence <= durable[robot], f"I4: a fence that is not on disk: {event}"
                fences[robot] = event.fence
                holder = claimed[event.cid].principal
                first = holders.setdefault((robot, event.fence), holder)
                assert first == holder, f"I12: two holders under one fence: {event}"


def stops_dominate(log: list[Event]) -> None:  # noqa: C901, PLR0915 - one story, told in order
    """I5, I8: what was said before a stop moves nothing after it; only a later resume undoes it.

    Looking is no motion: a stopped robot may be looked at. A crash may forget a stop that had not
    reached the stop file; the next gateway then knows no command of before it either.
    """
    stopped: dict[str, tuple[int, int]] = {}
    latched: set[str] = set()
    kept: dict[str, tuple[int, bool]] = {}
    said: dict[bytes, int] = {}
    revoked: set[str] = set()
    # Who had no access when the stop file was told that a robot is let go: by then it is decided.
    without: dict[str, set[str]] = {}
    for at, event in enumerate(log):
        if isinstance(event, Said):
            for cid in cids_of(event):
                said.setdefault(cid, at)
        elif isinstance(event, Revoked):
            revoked.add(event.who)
        elif isinstance(event, Latched):
            stopped[event.robot] = (at, event.generation)
            latched.add(event.robot)
        elif isinstance(event, Kept):
            kept[event.robot] = (event.generation, event.latched)
            without[event.robot] = set(revoked)
        elif isinstance(event, Started):
            for robot, (*_, holds) in event.gates.items():
                generation, was_latched = kept.get(robot, (0, False))
                assert holds or not was_latched, f"I5: {robot} was let go by a restart"
                if not holds and robot in latched:
                    latched.discard(robot)
                if stopped.get(robot, (0, 0))[1] > generation:
                    del stopped[robot]
        elif isinstance(event, Unlatched):
            since, _ = stopped.get(event.robot, (0, 0))
            ended = without.get(event.robot, revoked)
            reasons = [one for one in log[since:at] if undoes(one, event.robot, ended)]
            assert reasons, f"I5: nobody who may asked for it after the stop: {event}"
            latched.discard(event.robot)
        elif isinstance(event, Acted) and event.actuates:
            since, generation = stopped.get(event.robot, (-1, 0))
            assert event.robot not in latched, f"I5: it is stopped: {event}"
            assert event.generation >= generation, f"I5: an earlier generation: {event}"
            assert said.get(event.cid, at) > since, f"I5: said before the stop: {event}"


def undoes(event: Event, robot: str, revoked: set[str]) -> bool:
    """Whether something said is a resume that may undo a stop of a robot."""
    if not isinstance(event, Said) or event.who not in MOVERS - revoked:
        return False
    if event.standing is not MessageValidity.FRESH:
        return False
    first, *names = event.text.split()
    return first == "resume" and (
        not names or robot in names or ("swarm" in names and robot in SWARM) or names == ["all"]
    )


def outcomes_are_honest(log: list[Event]) -> None:  # noqa: C901 - one story, told in order
    """I7: done means once, refused means never, unknown means once at most."""
    acts = Counter(event.cid for event in log if isinstance(event, Acted))
    endings: defaultdict[bytes, set[str]] = defaultdict(set)
    for event in log:
        if isinstance(event, Written):
            for record in event.records:
                if isinstance(record, Concluded):
                    endings[record.cid].add(record.ending)
                elif isinstance(record, Refused):
                    endings[record.cid].add(OrderEnding.REFUSED.value)
    for cid, found in endings.items():
        assert len(found) == 1, f"I7: two endings: {found}"
        [ending] = found
        if ending == OrderEnding.DONE.value:
            assert acts[cid] == 1, "I7: done, and it did not act once"
        elif ending == OrderEnding.REFUSED.value:
            assert acts[cid] == 0, "I7: refused, and it acted"
        else:
            assert acts[cid] <= 1, f"I7: {ending}, and it acted twice"


def numbers_only_grow(log: list[Event]) -> None:
    """I13: over restarts n, fence and stop generation never fall behind what was on disk."""
    known: defaultdict[str, tuple[int, int, int]] = defaultdict(lambda: (0, 0, 0))
    for event in log:
        if isinstance(event, Started):
            for robot, (*numbers, _) in event.gates.items():
                grown = all(a >= b for a, b in zip(numbers, known[robot], strict=True))
                assert grown, f"I13: {robot} began with {numbers}, known were {known[robot]}"
        elif isinstance(event, Kept):
            n, fence, generation = known[event.robot]
            assert event.generation >= generation, f"I13: {event}"
            known[event.robot] = (n, fence, event.generation)
        elif isinstance(event, Written):
            for record in event.records:
                if isinstance(record, Claimed):
                    n, fence, generation = known[record.robot]
                    assert record.n > n, f"I13: an order number again: {record}"
                    known[record.robot] = (record.n, max(fence, record.fence), generation)


def every_actuation_has_its_message(log: list[Event]) -> None:
    """I14, I2, I8, I17: said before, by somebody who may, in a message that counts, and in time."""
    said: dict[bytes, Said] = {}
    revoked: set[str] = set()
    for event in log:
        if isinstance(event, Said):
            for cid in cids_of(event):
                said.setdefault(cid, event)
        elif isinstance(event, Revoked):
            revoked.add(event.who)
        elif isinstance(event, Acted):
            message = said.get(event.cid)
            assert message is not None, f"I14: nobody said this: {event}"
            may_look = message.standing is MessageValidity.UNVERIFIED and not event.actuates
            fresh = message.standing is MessageValidity.FRESH
            assert fresh or may_look, f"I17: {message} moved {event}"
            # Who may read a robot may also ask it for what only observes.
            able = MOVERS if event.actuates else MOVERS | WATCHERS
            assert message.who in able - revoked, f"I8: {message.who} may not: {event}"
            age_s = (event.wall_ns - message.sent_ns) / 1e9
            assert age_s <= event.lifetime_s, f"I2: {age_s} s after it was sent: {event}"


def nothing_is_left(world: World) -> None:
    """L1, and what must not leak: at the end nobody has a robot, waits, or was not told."""
    gateway = world.gateway
    rooms = gateway.rooms
    assert gateway.quiet, "something is still under way"
    assert not rooms.linker._latching
    for robot in gateway.robots:
        assert rooms.organiser.holder(robot) is None, f"{robot} is held for ever"
        assert rooms.linker.waiting(robot) == 0, f"something waits for {robot} for ever"
        assert rooms.linker.queues[robot].current is None, f"the queue of {robot} is stuck"
        assert rooms.stops[robot].latched == gateway.robots[robot].gate.latched, (
            f"{robot}: people are told one thing, the gate knows another"
        )
    assert not gateway.pipeline._chat_locks._chats, "a chat waits for its turn for ever"
    left = list(world.store._open_orders.values())
    assert not left, f"L1: never told: {left}"


def everybody_is_answered_once(world: World) -> None:
    """L1 without faults: one answer to each line of somebody known; no line is left unanswered.

    A question that comes again may be answered again.
    """
    answers = Counter(
        told.outbound.reply_to
        for told in world.chat.told
        if told.outbound.reply_to and not told.edited
    )
    for event in world.log:
        if isinstance(event, Said) and event.message and speaks(event, world):
            lines, found = len(event.text.splitlines()), answers[event.message]
            question = event.text.split()[0] in QUESTIONS
            right = found >= lines if question else found == lines
            assert right, f"L1: {found} answers to {event.text!r}"


def speaks(said: Said, world: World) -> bool:
    """Whether a message surely asks for one answer to each of its lines."""
    first = said.text.split()[0]
    known = said.who in {"Ada", "Bo", "Vi"} - world.revoked
    meant = said.private or first in {"swarm", *ROBOTS}  # people may talk to each other in a group
    return known and meant and said.standing is MessageValidity.FRESH and first != "stop"
