"""``/mission new dance``: a mission is put together in a chat, line by line, and saved."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.core.fleet.mission import TASKS_AT_MOST
from rosic.core.language import Do, LanguageReader, Misunderstood, bind
from rosic.core.language.vocabulary import means_else
from rosic.core.policy.scope import FLEET
from rosic.core.records import Decided
from rosic.core.time_units import MINUTE_NS
from rosic.errors import Expired, NotPermitted, NotUnderstood, OutOfBounds, TooManyRequests
from rosic.features.fleet import messages as fleet_words
from rosic.features.fleet import mission_messages as words
from rosic.features.fleet.mission_book import DraftStep, MissionDraft, MissionEntry
from rosic.features.fleet.task_commands import ASSIGN
from rosic.features.fleet.task_parser import PermittedSteps
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.identity import PrincipalId
    from rosic.core.language import Vocabulary
    from rosic.core.order import SpokenValue
    from rosic.core.records import Record
    from rosic.features.fleet.mission_book import MissionBook
    from rosic.gateway.agreement import Agreements
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.components import Components
    from rosic.gateway.transactions import Transactions

EDITS: Final = frozenset({"new", "add", "undo", "save", "share", "leave", "forget"})
"""What is done to a mission that is put together; no mission is called so."""
STEPS_AT_MOST: Final = 30
OF_ONE_AT_MOST: Final = 20
LEFT_AFTER_NS: Final = 30 * MINUTE_NS
"""A draft that nothing was done with for so long takes no line in any more."""
_NAME: Final = re.compile(r"[^\W\d_]\w{0,23}\Z")


class MissionBuilder:
    """Puts missions together.

    Attributes:
        book: Where they are kept.
    """

    def __init__(
        self,
        rooms: Components,
        changes: Transactions,
        book: MissionBook,
        agreements: Agreements,
    ) -> None:
        self.book = book
        self._rooms = rooms
        self._changes = changes
        self._agreements = agreements
        self._reader = LanguageReader(rooms.vocabularies)

    async def edit(self, asked: CommandContext, verb: str, said: str) -> Reply:
        """Do something with the mission that somebody puts together.

        Args:
            asked: By whom.
            verb: One of `EDITS`.
            said: What follows it.

        Raises:
            NotUnderstood: There is none, or a line is no order.
            NotPermitted: They may not let a robot do that.
            TooManyRequests: There are too many.
        """
        who = asked.caller.principal
        if verb == "new":
            return await self._new(asked, said.casefold())
        if verb == "forget":
            return await self._forget(asked, said.casefold())
        draft = self.book.drafts.get(who)
        if draft is None:
            raise NotUnderstood(words.NO_DRAFT)
        if verb == "leave":
            await self._write(asked, (self.book.draft_fact(who, None),))
            return Reply(words.left(draft.name))
        if verb == "add":
            return await self._add(asked, draft, said)
        if verb == "undo":
            return await self._keep(asked, replace(draft, steps=draft.steps[:-1]))
        return await self._save(asked, draft, shared=verb == "share")

    async def _new(self, asked: CommandContext, name: str) -> Reply:
        who = asked.caller.principal
        declared = self._rooms.vocabulary.commands.find("mission")
        acts = () if declared is None else declared.verbs.values()
        if not _NAME.match(name) or name in EDITS or name in acts or means_else(name):
            raise NotUnderstood(words.NAME_OF_ONE_WORD)
        if name in self.book.of(who):
            raise NotUnderstood(words.name_taken(name), offers=(f"/mission {name}",))
        before = self.book.drafts.get(who)
        if before is not None:
            raise NotUnderstood(words.drafts_already(before.name), offers=("/mission leave",))
        if self.book.count(who) >= OF_ONE_AT_MOST:
            raise TooManyRequests(words.too_many_saved(OF_ONE_AT_MOST), retry_after_s=60.0)
        chat = asked.inbound.chat
        return await self._keep(asked, MissionDraft(name, asked.messenger.name, chat, (), 0))

    async def _add(self, asked: CommandContext, draft: MissionDraft, said: str) -> Reply:
        """Take in one line as a step; no robot does anything because of it.

        Raises:
            Expired: Nothing was done with the mission for long: the line may have been meant as an
                order, so neither is done.
        """
        who, now_ns = asked.caller.principal, self._rooms.organiser.wall_ns()
        if now_ns - draft.touched_ns > LEFT_AFTER_NS:
            await self._write(asked, (self.book.draft_fact(who, None),))
            raise Expired(words.left_long_ago(draft.name))
        if len(draft.steps) >= STEPS_AT_MOST:
            raise OutOfBounds(words.draft_full(STEPS_AT_MOST))
        step = await self._step(asked, said)
        if sum(len(each.robots) for each in (*draft.steps, step)) > TASKS_AT_MOST:
            raise OutOfBounds(words.draft_too_large(TASKS_AT_MOST))
        return await self._keep(asked, replace(draft, steps=(*draft.steps, step)))

    async def _step(self, asked: CommandContext, said: str) -> DraftStep:
        rooms, who = self._rooms, asked.caller.principal
        selected = rooms.container.selected(who, asked.inbound.chat)
        [line, *_] = self._reader.lines(said, selected, rooms.organiser.visible(who))
        if isinstance(line, Misunderstood):
            offers = tuple(f"/mission add {offer}" for offer in line.offers)
            raise NotUnderstood(line.sentence, offers=offers)
        if not isinstance(line, Do):
            raise NotUnderstood(words.no_step(said))
        text = _said_anew(rooms.vocabulary, line)
        permitted = PermittedSteps(rooms, who)
        if len(line.robots) > TASKS_AT_MOST:
            raise OutOfBounds(words.draft_too_large(TASKS_AT_MOST))
        for robot, skill in zip(line.robots, line.skills, strict=True):
            await permitted.look(robot, (text,), to_the_end=False)  # others have their turn
            permitted.all(robot, (text,))
            read = permitted.reader.read(robot, text)
            arguments = bind(rooms.vocabulary, robot, skill, line.spoken, group=line.group)
            if bind(rooms.vocabulary, robot, read.skills[0], read.spoken) != arguments:
                shown = rooms.profiles[robot].shown
                raise NotUnderstood(fleet_words.no_command(shown, said))
        shown = str(self._agreements.of(line, asked.caller).shown)
        return DraftStep(line.robots, text, shown)

    async def _save(self, asked: CommandContext, draft: MissionDraft, *, shared: bool) -> Reply:
        who = asked.caller.principal
        if not draft.steps:
            raise NotUnderstood(words.NOTHING_TO_SAVE)
        if shared:
            self._check_shares(who)
        if draft.name in self.book.of(who):  # somebody has shared one of that name meanwhile
            raise NotUnderstood(words.name_taken(draft.name))
        saved = self.book.saved_fact(MissionEntry(who, shared), draft)
        await self._write(asked, (saved, self.book.draft_fact(who, None)))
        return Reply(words.saved(draft.name, everybody=shared), words.start_buttons((draft.name,)))

    def _check_shares(self, who: PrincipalId) -> None:
        if not self._shares(who):
            raise NotPermitted(words.MAY_NOT_SHARE)

    def _shares(self, who: PrincipalId) -> bool:
        organiser = self._rooms.organiser
        return organiser.rights.holds(who, FLEET, ASSIGN, organiser.wall_ns())

    async def _forget(self, asked: CommandContext, name: str) -> Reply:
        fact = self.book.forgotten_fact(asked.caller.principal, name)
        if fact is None:
            raise NotUnderstood(words.not_saved(name))
        await self._write(asked, (fact,))
        return Reply(words.forgotten(name))

    async def _keep(self, asked: CommandContext, draft: MissionDraft) -> Reply:
        """Write a draft down, and show it."""
        who, now_ns = asked.caller.principal, self._rooms.organiser.wall_ns()
        draft = replace(draft, touched_ns=now_ns)
        await self._write(asked, (self.book.draft_fact(who, draft),))
        text = words.draft(draft.name, [step.shown for step in draft.steps])
        return Reply(text, words.draft_buttons(some=bool(draft.steps), shares=self._shares(who)))

    async def _write(self, asked: CommandContext, facts: Iterable[Record]) -> None:
        decided = Decided(
            act="mission-draft",
            by=asked.caller.principal,
            about=asked.caller.principal,
            at_ns=self._rooms.organiser.wall_ns(),
            digest=asked.cid,
        )
        async with self._changes.turn() as turn:
            await turn.write((decided, *facts))


def _said_anew(vocabulary: Vocabulary, line: Do) -> str:
    """Return what a line asks, without a name, with every value as it was read."""
    compiled = vocabulary.compiled_skill(line.robots[0], line.skills[0].id)
    if compiled is None:
        return line.text
    if compiled.text is not None:
        return " ".join((compiled.spoken, *(value.word for value in line.spoken)))
    return " ".join((compiled.spoken, *map(_as_said, line.spoken)))


def _as_said(value: SpokenValue) -> str:
    number = "" if value.number is None else f"{value.number:.10g}"
    text = " ".join(filter(None, (number, value.word)))
    return f"{value.name}={text}" if value.name else text
