"""A lab with people, robots and times; its clock stands at 10:00 in Vienna on 21 November 2026."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.app.features import command_table
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.config.profiles import known_units
from rosic.container.container import Containers
from rosic.core.identity import Address, AuthorisationKey, Caller, CommandId, Principal
from rosic.core.language import CommandLine, LanguageReader, Vocabulary, VocabularyHolder
from rosic.core.lease import Lease
from rosic.core.message import Chat, ChatKind, Inbound
from rosic.core.robot.profile import Link, Profile, Slots
from rosic.core.robot.skill import Skill
from rosic.core.slot import SERIES, SLOT
from rosic.errors import NotPermitted, Refusal, RobotUnreachable, StoreFault
from rosic.features.booking.commands import register_commands
from rosic.features.booking.context import BookingContext, BookingQueries
from rosic.features.booking.scheduler import BookingScheduler
from rosic.gateway.access_registry import authoriser_of
from rosic.gateway.cancel import BOOKING
from rosic.gateway.commands import CommandContext, CommandRegistry
from rosic.gateway.delivery.last_accounts import LastAccounts
from rosic.gateway.delivery.notifier import Notifier, nobody_to_tell
from rosic.gateway.delivery.outbox import Outbox
from rosic.gateway.delivery.sender import ChatSender
from rosic.gateway.transactions import Transactions
from rosic.messengers.memory import MemoryMessenger
from rosic.organiser.calendar import Calendar, CalendarNames
from rosic.organiser.planning.wishes import WISH, Wishes
from rosic.organiser.wait_queue import WAITING, WaitingList
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, SeededEntropy, settle
from tests.organiser.booking import HOUR, MIN, NOW, VIENNA

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.message import Button
    from rosic.core.records import Record
    from rosic.core.slot import BookedSlot
    from rosic.gateway.commands import Reply
    from rosic.organiser.timezones import Zone

__all__ = ["HOUR", "MIN", "NOW", "VIENNA", "Lab"]

ANN, BEN, CEM, ADA, VI = "ann", "ben", "cem", "ada", "vi"
NAMES = {ANN: "Ann", BEN: "Ben", CEM: "Cem", ADA: "Ada", VI: "Vi"}
IDLE_S = 60.0


def profile(name: str, title: str = "", *, slots: Slots, groups: tuple[str, ...] = ()) -> Profile:
    return Profile(
        id=name,
        title=title,
        link=Link(kind="memory"),
        groups=groups,
        slots=slots,
        skills={"wave": Skill(id="wave", title="Wave")},
    )


FLEET = (
    profile("kuka1", "KUKA iiwa", slots=Slots.RESPECTED, groups=("desks",)),
    profile("omni", slots=Slots.REQUIRED),
    profile("arm", "The Arm", slots=Slots.RESPECTED, groups=("desks",)),
    profile("cf1", slots=Slots.NONE, groups=("swarm",)),
    profile("cf2", slots=Slots.NONE, groups=("swarm",)),
)


class FullDisk(MemoryStore):
    """Writes nothing while it is full."""

    full = False

    async def write(self, *records: Record) -> None:
        if self.full:
            raise StoreFault("the disk is full")
        await super().write(*records)


class Lab:
    """Everything about times, for real, but the robots: those are leases and a way to rest.

    Attributes:
        handed: Which robots were handed over, why, and when after 10:00 in seconds.
        rest_s: How long it takes a robot to come to rest.
        confirms: Whether robots confirm that they are at rest.
        breaks: Whether handing over fails altogether.
        hidden: Robots that nobody but Ann may see.
        forbidden: Who may move no robot.
        away: Robots that are stopped or not there.
        barred: Robots that nobody can resume, and why.
    """

    def __init__(self, store: MemoryStore | None = None, clock: ManualClock | None = None) -> None:
        self.clock = clock or ManualClock(NOW)
        self.store = store or MemoryStore()
        self.handed: list[tuple[str, str, float]] = []
        self.rest_s = 0.5
        self.confirms = True
        self.breaks = False
        self.hidden: set[str] = set()
        self.forbidden = {VI}
        self.away: set[str] = set()
        self.barred: dict[str, Refusal] = {}
        self.may_not_resume: set[str] = set()
        self.zones: dict[str, Zone] = {}
        self.seniors: set[str] = set()
        self.selected: dict[str, str] = {}
        self.leases = {robot.id: Lease(0) for robot in FLEET}
        self.chat = self.messenger()
        self.reply: Reply | None = None
        self.refusal: Refusal | None = None
        self._serial = 0
        self._seen = 0
        self._compose()

    def messenger(self) -> MemoryMessenger:
        """Return where people read."""
        return MemoryMessenger(clock=self.clock)

    def _compose(self) -> None:
        clock = self.clock
        vocabularies = VocabularyHolder(Vocabulary.build(FLEET, known_units(), command_table()))
        self.reader = LanguageReader(vocabularies)
        self.authoriser = authoriser_of(MonotonicWallClock(clock), clock, SeededEntropy())
        for who, name in NAMES.items():
            person = Principal(id=who, name=name, addresses=(Address("memory", who),))
            key = AuthorisationKey(id=f"k{who}", principal=who, issuer=ADA, issued_ns=0)
            self.authoriser.enrol(person, key)
        chat_sender = ChatSender(
            Containers(vocabularies, self.store, clock, {}, usual={}),
            clock,
            nobody_to_tell,
        )
        outbox = Outbox(self.store, clock, SeededEntropy(), chat_sender)
        self.changes = Transactions(self.store, clock)
        names = CalendarNames(
            name_of=NAMES.__getitem__,
            shown_of=lambda robot: vocabularies.current.profiles[robot].shown,
            zone_of=lambda who: self.zone_of(who).name,
        )
        self.calendar = Calendar(clock, names)
        self.waiting = WaitingList(clock, names.shown_of)
        self.changes.keep(SLOT, self.calendar.apply)
        self.changes.keep(SERIES, self.calendar.apply)
        self.wishes = Wishes(clock.wall_ns)
        self.changes.keep(WAITING, self.waiting.apply)
        self.changes.keep(WISH, self.wishes.apply)
        self.times = BookingContext(
            calendar=self.calendar,
            waiting=self.waiting,
            wishes=self.wishes,
            vocabularies=vocabularies,
            changes=self.changes,
            reach=Notifier(
                self.authoriser,
                chat_sender,
                (self.chat,),
                outbox,
                LastAccounts(self.authoriser.directory, self.store.note),
            ),
            clock=clock,
            sides=BookingQueries(
                visible=self.visible,
                may_book=self._may_book,
                may_cancel_any=lambda who, _: who == ADA,
                selected=lambda who, _: self.selected.get(who, ""),
                zone_of=self.zone_of,
                lease=self.leases.__getitem__,
                ready=lambda robot: robot not in self.away,
                handover=self._handover,
                barred=self.barred.get,
                may_resume=lambda who, _: who not in self.may_not_resume,
                may_stay=lambda who, _: who in self.seniors,
                right_ends_ns=lambda _who, _robot: None,
            ),
            lease_idle_s=IDLE_S,
        )
        self.scheduler = BookingScheduler(self.times)
        self.changes.after(self.scheduler.look)
        self.commands = CommandRegistry(command_table())
        register_commands(self.commands, self.times, self.scheduler)
        self.commands.register("cancel", self._cancel_booking)

    # ---- the other rooms ----

    def zone_of(self, who: str) -> Zone:
        return self.zones.get(who, VIENNA)

    def visible(self, who: str) -> frozenset[str]:
        return frozenset(r.id for r in FLEET if who == ANN or r.id not in self.hidden)

    def _may_book(self, who: str, _: str) -> Refusal | None:
        return NotPermitted("That needs a right you lack.") if who in self.forbidden else None

    async def _handover(self, robot: str, reason: str) -> bool:
        self.handed.append((robot, reason, self.since()))
        await self.clock.sleep(self.rest_s)
        if self.breaks:
            raise RobotUnreachable(f"{robot} does not answer.")
        self.leases[robot].release()
        if not self.confirms:
            self.away.add(robot)
        return self.confirms

    def begin(self, who: str, robot: str = "kuka1") -> None:
        """Let somebody's order begin."""
        self.leases[robot].take(who, self.clock.monotonic_ns(), int(IDLE_S * 1e9))

    def end(self, robot: str = "kuka1") -> None:
        """Let it end."""
        lease = self.leases[robot]
        lease.settle(lease.fence, self.clock.monotonic_ns())

    def holder(self, robot: str) -> str | None:
        """Return who has a robot now."""
        return self.leases[robot].holder_at(self.clock.monotonic_ns(), int(IDLE_S * 1e9))

    def since(self) -> float:
        """Return how many seconds after 10:00 it is."""
        return (self.clock.wall_ns() - NOW) / 1e9

    # ---- people ----

    async def say(self, who: str, text: str, *, kind: ChatKind = ChatKind.PRIVATE) -> str:
        """Say something and return the answer; a refusal's sentence is one too."""
        (line,) = self.reader.lines(text, self.selected.get(who, ""), self.visible(who))
        assert isinstance(line, CommandLine), line
        address = Address("memory", who)
        inbound = Inbound(
            sender=address,
            chat=Chat("memory", who, kind),
            message="1",
            text=text,
            sent_ns=self.clock.wall_ns(),
            received_ns=self.clock.wall_ns(),
        )
        caller = Caller(who, NAMES[who], address, f"k{who}", "s")
        self._serial += 1
        cid: CommandId = self._serial.to_bytes(16, "big")
        self.reply = self.refusal = None
        try:
            self.reply = await self.commands.do(
                line, CommandContext(self.chat, inbound, caller, line.rest, cid)
            )
        except Refusal as refusal:
            self.refusal = refusal
            return str(refusal)
        return self.reply.text

    async def _cancel_booking(self, asked: CommandContext) -> Reply:
        """Do what the gateway leaves of ``/cancel`` to bookings."""
        return await self.commands.do(CommandLine(BOOKING, asked.rest), asked)

    def offers(self) -> tuple[str, ...]:
        """Return what the last refusal offers."""
        assert self.refusal is not None, self.reply
        return self.refusal.offers

    def labels(self) -> list[str]:
        """Return what is on the buttons of the last answer."""
        assert self.reply is not None, self.refusal
        return [button.label for row in self.reply.buttons for button in row]

    async def tap(self, who: str, label: str) -> str:
        """Tap a button of the last answer."""
        assert self.reply is not None, self.refusal
        (found,) = [b for row in self.reply.buttons for b in row if b.label == label]
        return await self.say(who, found.command)

    async def tap_told(self, who: str, label: str) -> str:
        """Tap the newest button with a label that somebody was shown unasked."""
        button = self._shown(label)
        inbound = Inbound(
            sender=Address("memory", who),
            chat=Chat("memory", who),
            message="1",
            text="",
            nonce=button.nonce,
            sent_ns=self.clock.wall_ns(),
            received_ns=self.clock.wall_ns(),
        )
        try:
            command = self.authoriser.buttons.redeem(button.nonce, who, inbound).command
        except Refusal as refusal:
            return str(refusal)
        return await self.say(who, command)

    def _shown(self, label: str) -> Button:
        for told in reversed(self.chat.told):
            for row in told.outbound.buttons:
                for button in row:
                    if button.label == label:
                        return button
        raise AssertionError(f"no button {label!r}")

    # ---- what is told unasked ----

    async def told(self, seconds: float = 0.0) -> list[tuple[str, str]]:
        """Let time pass; return what was told to whom since the last call."""
        await self.clock.advance(seconds)
        for _ in range(3):
            await settle()
        new = list(self.chat.told)[self._seen :]
        self._seen = len(self.chat.told)
        return [(told.outbound.chat.id, told.outbound.text) for told in new]

    async def told_until(self, minutes: float) -> list[tuple[str, str]]:
        """Let time pass until so many minutes after 10:00 by the wall clock."""
        return await self.told(minutes * 60 - self.since())

    async def book(self, who: str, text: str) -> BookedSlot:
        """Book, and return the slot that comes last."""
        said = await self.say(who, f"/book {text}")
        assert "is yours" in said, said
        return self.calendar.of(who)[-1]

    def decisions(self) -> list[tuple[str, str]]:
        """Return who decided what."""
        return [(decided.act, decided.by) for decided in self.store._decisions]

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Lab]:
        """Let the keeper run."""
        memory = await self.store.open()
        self.calendar.restore((*memory.facts.get(SERIES, ()), *memory.facts.get(SLOT, ())))
        self.waiting.restore(memory.facts.get(WAITING, ()))
        self.wishes.restore(memory.facts.get(WISH, ()))
        running = asyncio.create_task(self.scheduler.run())
        await settle()
        try:
            yield self
            assert not running.done()
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            closing = asyncio.create_task(self.scheduler.close())
            while not closing.done():
                await self.clock.advance(1.0)
            await self._quiet()

    async def _quiet(self) -> None:
        """End every task that the teller left behind."""
        others = [t for t in asyncio.all_tasks() if t is not asyncio.current_task()]
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
