"""Missions by name: those of files, and those that people have put together in a chat."""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.fleet.mission import Mission, MissionPart
from rosic.core.fleet.task import STEPS_AT_MOST
from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.message import Chat
from rosic.core.records import Fact, Letter
from rosic.core.robot.profile import RobotId

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, MutableSet, Sequence

SAVED: Final = "chat-mission"
DRAFT: Final = "mission-draft"

log = logging.getLogger("rosic.fleet")


class DraftStep(msgspec.Struct, frozen=True):
    """One step of a mission that is put together.

    Attributes:
        robots: One, or all of a group: each of them does it.
        text: What it is asked, without its name, every value as it was read.
        shown: How it was shown.
    """

    robots: tuple[RobotId, ...]
    text: str
    shown: str


class MissionDraft(msgspec.Struct, frozen=True):
    """A mission that somebody puts together: while they do, what they type there is no order.

    Attributes:
        touched_ns: When something was last done with it, wall clock.
    """

    name: str
    messenger: str
    chat: Chat
    steps: tuple[DraftStep, ...]
    touched_ns: int


class KeptMission(msgspec.Struct, frozen=True):
    """A mission that somebody has saved, as it stands in their container."""

    name: str
    steps: tuple[DraftStep, ...]


class MissionEntry(msgspec.Struct, frozen=True):
    """Whose it is, and whether everybody here may start it: in the open."""

    author: PrincipalId
    shared: bool


_encode = msgspec.msgpack.Encoder().encode
_draft = msgspec.msgpack.Decoder(MissionDraft).decode
_saved = msgspec.msgpack.Decoder(KeptMission).decode
_owner = msgspec.msgpack.Decoder(MissionEntry).decode


class MissionBook:
    """Every mission, and every draft.

    Attributes:
        of_files: Those of the configuration, by name.
        drafts: By who puts them together.

    Args:
        drafting: Where what somebody types is part of a draft: kept up to date here.
    """

    def __init__(
        self,
        missions: Iterable[Mission],
        drafting: MutableSet[tuple[PrincipalId, str, str]],
    ) -> None:
        self.of_files = {mission.name: mission for mission in missions}
        self.drafts: dict[PrincipalId, MissionDraft] = {}
        self._drafting = drafting
        self._saved: dict[str, tuple[MissionEntry, Mission]] = {}
        self._known: dict[PrincipalId, dict[str, Mission]] = {}

    # ---- what is written ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; one whose author's container is erased is none."""
        try:
            if fact.kind == DRAFT:
                self._apply_draft(fact)
            else:
                self._apply_saved(fact)
        except (msgspec.MsgspecError, ValueError):
            log.warning("a mission of a chat cannot be read; it is left out")

    def _apply_draft(self, fact: Fact) -> None:
        before = self.drafts.pop(fact.key, None)
        if before is not None:
            self._drafting.discard((fact.key, before.messenger, before.chat.id))
        if fact.body and fact.letter is not None:
            draft = _draft(fact.letter.content)
            self.drafts[fact.key] = draft
            self._drafting.add((fact.key, draft.messenger, draft.chat.id))

    def _apply_saved(self, fact: Fact) -> None:
        self._saved.pop(fact.key, None)
        self._known.clear()
        if fact.body and fact.letter is not None:
            saved = _saved(fact.letter.content)
            self._saved[fact.key] = _owner(fact.body), mission_of(saved.name, saved.steps)

    def draft_fact(self, who: PrincipalId, draft: MissionDraft | None) -> Fact:
        """Return what keeps somebody's draft, or ends it."""
        if draft is None:
            return Fact(kind=DRAFT, key=who, body=b"")
        return Fact(kind=DRAFT, key=who, body=b"1", letter=Letter(who, _encode(draft)))

    def saved_fact(self, owner: MissionEntry, draft: MissionDraft) -> Fact:
        """Return what keeps a mission."""
        letter = Letter(owner.author, _encode(KeptMission(draft.name, draft.steps)))
        key = _key(owner.author, draft.name)
        return Fact(kind=SAVED, key=key, body=_encode(owner), letter=letter)

    def forgotten_fact(self, who: PrincipalId, name: str) -> Fact | None:
        """Return what forgets a mission that somebody has saved; None: they have none."""
        key = _key(who, name)
        return Fact(kind=SAVED, key=key, body=b"") if key in self._saved else None

    def end_all(self, who: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends everything that somebody has put together."""
        keys = [key for key, (owner, _) in self._saved.items() if owner.author == who]
        ends = tuple(Fact(kind=SAVED, key=key, body=b"") for key in keys)
        return (*ends, self.draft_fact(who, None)) if who in self.drafts else ends

    # ---- which there are ----

    def of(self, who: PrincipalId) -> Mapping[str, Mission]:
        """Return every mission that somebody may name: of files, of everybody, and their own."""
        known = self._known.get(who)
        if known is None:
            shared = {m.name: m for owner, m in self._saved.values() if owner.shared}
            own = {m.name: m for owner, m in self._saved.values() if owner.author == who}
            known = self._known[who] = {**shared, **own, **self.of_files}
        return known

    def count(self, who: PrincipalId) -> int:
        """Return how many missions somebody has saved."""
        return sum(owner.author == who for owner, _ in self._saved.values())


def mission_of(name: str, steps: Sequence[DraftStep]) -> Mission:
    """Return what is started: one step after another; what one robot does in a row is one task."""
    parts: list[MissionPart] = []
    for step in steps:
        if len(step.robots) > 1:
            each = tuple(MissionPart(on=robot, steps=(step.text,)) for robot in step.robots)
            parts.append(MissionPart(together=each))
            continue
        [robot] = step.robots
        last = parts[-1] if parts else None
        if last is not None and last.on == robot and len(last.steps) < STEPS_AT_MOST:
            parts[-1] = MissionPart(on=robot, steps=(*last.steps, step.text))
        else:
            parts.append(MissionPart(on=robot, steps=(step.text,)))
    return Mission(name=name, do=tuple(parts))


def _key(author: PrincipalId, name: str) -> str:
    """Return a digest: names stand in the container alone."""
    return blake2b(f"{author}/{name}".encode(), digest_size=DIGEST_BYTES).hexdigest()
