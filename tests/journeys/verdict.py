"""What must hold of a whole journey, whatever happened on the way."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING

import msgspec

from rosic.core.identity import command_id, robot_command_id
from tests.journeys.fleet import TOKEN
from tests.journeys.reading import ACTED, End, Reply

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from tests.journeys.counter import Counted
    from tests.journeys.counting import Event


BOT = TOKEN.partition(":")[0]


class Said(msgspec.Struct, frozen=True):
    """One command as a person sent it.

    Attributes:
        message: The platform's id; with the chat it is the command's identity.
        robots: Whom it asks; several for a group.
    """

    chat: int
    user: int
    message: int
    text: str
    robots: tuple[str, ...]

    def cids(self) -> tuple[str, ...]:
        """Return the identities of its shares, computed as ROSIC does: from the message alone."""
        # Only a supergroup numbers its messages for all: elsewhere each bot has numbers of its own.
        whose = (str(self.user),) if str(self.chat).startswith("-100") else ("to", BOT)
        cid = command_id("telegram", *whose, str(self.chat), str(self.message), "0")
        others = (robot_command_id(cid, robot) for robot in self.robots[1:])
        return tuple(one.hex() for one in (cid, *others))


class Verdict(msgspec.Struct):
    """What was found.

    Attributes:
        wrong: Sentences; empty if everything held.
        endings: How many commands ended how; a group's count once for each robot.
        said_again: How many replies were marked as perhaps said before.
        untold: Commands whose end nobody has read.
    """

    wrong: list[str]
    endings: Counter[End]
    said_again: int = 0
    untold: int = 0


def judge(
    commands: Iterable[Said],
    replies: Mapping[tuple[int, int], Sequence[Reply]],
    events: Sequence[Counted],
) -> Verdict:
    """Judge a journey.

    Args:
        commands: Everything that was asked.
        replies: By chat and message that they answer.
        events: What the robots were told, in order of arrival.
    """
    verdict = Verdict([], Counter())
    told = [counted.event for counted in events]
    verdict.wrong += order_of_events(told)
    acted = Counter(event.cid for event in told if event.cid)
    known: set[str] = set()
    summarised = _summarised(replies)
    for command in commands:
        known.update(command.cids())
        found = replies.get((command.chat, command.message), ())
        if not found and summarised[command.chat] and not any(map(acted.get, command.cids())):
            summarised[command.chat] -= 1  # one of those that nobody heard
            verdict.endings[End.EXPIRED] += 1
        else:
            _judge_one(verdict, command, found, acted)
    verdict.wrong += [f"I14: {cid} was asked by nobody" for cid in acted if cid not in known]
    return verdict


def _summarised(replies: Mapping[tuple[int, int], Sequence[Reply]]) -> Counter[int]:
    """Return of how many commands each chat was told at once that they were not carried out."""
    counted: Counter[int] = Counter()
    for (chat, _), found in replies.items():
        for reply in found:
            counted[chat] += reply.summarised
    return counted


def order_of_events(events: Sequence[Event]) -> list[str]:
    """Return what is wrong with the order in which robots were told (I1, I3, I4, I5)."""
    wrong: list[str] = []
    seen: set[str] = set()
    n: dict[str, int] = defaultdict(int)
    fence: dict[str, int] = defaultdict(int)
    generation: dict[str, int] = defaultdict(int)
    for event in events:
        robot = event.robot
        if event.generation < generation[robot]:
            wrong.append(f"I5: {robot} was told under stop {event.generation} after a later one")
        generation[robot] = max(generation[robot], event.generation)
        if not event.cid:
            continue
        if event.cid in seen:
            wrong.append(f"I1: {robot} acted twice on {event.cid}")
        seen.add(event.cid)
        if event.n <= n[robot]:
            wrong.append(f"I3: {robot} acted on n {event.n} after {n[robot]}")
        if event.fence < fence[robot]:
            wrong.append(f"I4: {robot} acted under fence {event.fence} after {fence[robot]}")
        n[robot], fence[robot] = max(n[robot], event.n), max(fence[robot], event.fence)
    return wrong


def _judge_one(
    verdict: Verdict, command: Said, replies: Sequence[Reply], acted: Counter[str]
) -> None:
    what = f"{command.text!r} (message {command.message} in {command.chat})"
    ended = [reply for reply in replies if reply.last]
    first = [reply for reply in ended if not reply.again]
    verdict.said_again += len(ended) - len(first)
    if not ended:
        verdict.untold += 1
        texts = [reply.text for reply in replies]
        verdict.wrong.append(f"L1: {what}: nobody was told how it ended: {texts}")
        return
    for reply in replies:
        verdict.wrong += [f"I7: {what}: {line!r} is no ending" for line in reply.strange]
    if len(first) > 1:
        texts = [reply.text for reply in first]
        verdict.wrong.append(f"L1: {what}: told {len(first)} times, unmarked: {texts}")
    endings = (first or ended)[-1].last
    verdict.endings.update(endings)
    whole = len(endings) == 1 and endings[0] in {End.REFUSED, End.EXPIRED}
    if len(endings) != len(command.robots) and not whole:
        texts = [reply.text for reply in ended]
        verdict.wrong.append(f"I7: {what}: {len(endings)} endings: {texts}")
        return
    if len(command.robots) == 1:
        seen = {end for reply in replies for form in reply.endings for end in form}
        if len(seen) > 1:
            verdict.wrong.append(f"I7: {what}: it was told to have ended as {seen}")
    low, high = (sum(ACTED[end][bound] for end in endings) for bound in (0, 1))
    times = sum(acted[cid] for cid in command.cids())
    if not low <= times <= high:
        words = ", ".join(end.value for end in endings)
        verdict.wrong.append(f"I7: {what}: told {words}, but {times} actuations")
