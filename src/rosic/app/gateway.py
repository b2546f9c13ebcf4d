"""The composition root: parts in, a running gateway out. The only module that knows all rooms."""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING

from rosic.app.added_robots import KIND as ADDED
from rosic.app.added_robots import settings_with_added
from rosic.app.containers import (
    preferences_of,
    recorded,
)
from rosic.app.features import Features, command_table
from rosic.app.gateway_parts import RunningGateway, kernel_of
from rosic.app.maintenance import (
    Maintenance,
    RecordMonitor,
    Retention,
    rates_of,
    save,
    save_now_and_then,
)
from rosic.app.messenger_setup import take_in
from rosic.app.people import remember, seed
from rosic.app.robot_provisioning import RobotProvisioning
from rosic.app.robot_startup import RobotStartup, robots_of, stop_registry_of, warn_of_thieves
from rosic.app.settings import GatewayParts, GatewaySettings
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.config.lexicons import known_phrases
from rosic.config.plugins import LANGUAGES, catalogue, whose
from rosic.container.archive import Archive
from rosic.container.container import Containers
from rosic.contracts.console import SupportsCompletion
from rosic.contracts.programs import serve_programs
from rosic.contracts.store import AuditStore
from rosic.core.language import Vocabulary, VocabularyHolder, inert_text
from rosic.core.message import Outbound
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import fleet_of
from rosic.core.policy.validation import rulebook_mistakes
from rosic.core.signal import Deferred
from rosic.errors import ConfigurationError
from rosic.gateway import Pipeline
from rosic.gateway.access_registry import (
    AbuseResponse,
    AccessRegistry,
    PlaceNames,
    admins_of,
    authoriser_of,
)
from rosic.gateway.components import Components
from rosic.gateway.confirmation import Confirmation
from rosic.gateway.delivery.last_accounts import LastAccounts
from rosic.gateway.delivery.notifier import Notifier, UndeliverableHandler, nobody_to_tell
from rosic.gateway.delivery.outbox import Outbox
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage
from rosic.gateway.delivery.translation import ChatLanguages
from rosic.gateway.hooks import PipelineHooks
from rosic.gateway.order_execution import inert_words
from rosic.gateway.policy_service import PolicyEnforcer, PolicyService
from rosic.gateway.programs import ProgramService
from rosic.gateway.recovery import Recovery
from rosic.gateway.resume import ResumeHandler
from rosic.gateway.robot_registry import RobotRegistry
from rosic.gateway.stop import StopLane
from rosic.linker.linker import Linker
from rosic.organiser.calendar import CalendarNames
from rosic.organiser.organiser import Organiser

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from rosic.authoriser.authoriser import Authoriser
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.robot import Robot
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.errors import ChatGone
    from rosic.gateway.confirmation import Resolver
    from rosic.gateway.delivery.chat_queue import Item
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["Gateway", "GatewayParts", "GatewaySettings"]

log = logging.getLogger("rosic.gateway")

# How long telling may take at the end: all of it is over before a signal's 5 s are.
FLUSH_S = 2.0
DEAF_WITHIN_S = 1.5
FLUSH_AT_LEAST_S = 0.2
TOLD_BY_S = 3.8
HOLD_WITHIN_S = 0.3


class Gateway(RunningGateway):
    """A running gateway: rooms, features and adapters, put together.

    Attributes:
        outbox: Keeps what is still to be said, over a crash.
        robot_adder: Adds robots while it runs.
    """

    outbox: Outbox
    robot_adder: RobotProvisioning

    def __init__(self, settings: GatewaySettings, parts: GatewayParts) -> None:
        self._settings = settings
        self._parts = parts
        self._messengers: tuple[Messenger, ...] = parts.messengers
        self._opened: list[Robot] = []
        self._listening: list[asyncio.Task[None]] = []
        self._chat_sender: ChatSender | None = None
        # How what has been made ends: opening may break off half-way.
        self._closes: list[Callable[[], Awaitable[None]]] = []
        self._leaves: list[Callable[[], Awaitable[None]]] = []
        self._ends: list[Callable[[], Awaitable[None]]] = []

    async def open(self) -> None:
        """Read the record, make the rooms, connect the robots, settle what was interrupted.

        Raises:
            ConfigurationError: Nothing has been started; whatever was opened is closed again.
        """
        vocabulary = self._vocabulary()
        memory = await self._parts.store.open()
        try:
            if self._know_added(memory):
                vocabulary = self._vocabulary()
            self._check_care()
            await self._compose(memory, vocabulary)
            await self.features.restore()
            tell = partial(self._tell_admins, urgent=False)
            opening = RobotStartup(self._robot_says, tell, self._opened)
            await opening.all(self.robots.values())
            await self._recover(memory)
        except BaseException:
            await self.close()
            raise

    def _know_added(self, memory: Memory) -> bool:
        """Know the robots that earlier runs have added, too. Return whether there are any."""
        before = self._settings
        self._settings = settings_with_added(before, memory.facts.get(ADDED, ()), self._parts.units)
        return len(self._settings.profiles) > len(before.profiles)

    def _tell_of_robots(self) -> None:
        """Have whoever keeps something per robot told of each that is added, in this order."""
        self.registry = RobotRegistry(self.rooms, self.profiles, self.robots)
        for told in (self.pipeline.robot_added, self._robot_added, self.features.robot_added):
            self.registry.added.connect(told)

    def _robot_added(self, newcomer: AddedRobot) -> None:
        """Close it with the gateway, bound how often it is asked, and let its name be completed."""
        self._opened.append(newcomer.robot)
        if self._settings.robot_limit is not None:
            rates = self.rooms.organiser.rates
            rates.add_robot(newcomer.profile.id, self._settings.robot_limit)
        for messenger in self._parts.messengers:
            if isinstance(messenger, SupportsCompletion):
                messenger.know(self.profiles.values(), self.rooms.vocabulary.commands)

    def _check_care(self) -> None:
        """See that no rule reads as if it protected, and is never asked for (I18).

        A file is looked at when it is read; whoever makes a gateway in Python comes by here alone.
        """
        fleet, convert = fleet_of(self._settings.profiles), unit_converter(self._parts.units)
        mistakes = rulebook_mistakes(self._settings.rulebook, fleet, convert)
        # What is wrong with a role gives less, and a robot may yet be added.
        for place, sentence, hint in mistakes if fleet.skills else ():
            if place[0] == "care":
                raise ConfigurationError(sentence, where=".".join(map(str, place)), hint=hint)

    def _vocabulary(self) -> Vocabulary:
        try:
            return Vocabulary.build(
                self._settings.profiles, self._parts.units, command_table(), known_phrases()
            )
        except ValueError as wrong:
            raise ConfigurationError(str(wrong)) from wrong

    async def _compose(self, memory: Memory, vocabulary: Vocabulary) -> None:
        parts, settings = self._parts, self._settings
        profiles = self.profiles = {profile.id: profile for profile in settings.profiles}
        stops = stop_registry_of(profiles, parts.latch.read(), memory)
        numbers = {robot: memory.numbers.get(robot, (0, 0)) for robot in profiles}
        self.robots = robots_of(parts, profiles, numbers, stops)
        time = MonotonicWallClock(parts.clock)
        authoriser = authoriser_of(time, parts.clock, parts.entropy)
        self.preferences = preferences_of(profiles.values(), parts.units, parts.clock, memory)
        authority = await self._authority(authoriser, memory)
        self.access = AccessRegistry(
            authoriser,
            authority,
            parts.store,
            parts.entropy,
            stops,
            PlaceNames(settings.place, self._names(authoriser)),
        )
        self._leaves.append(self._leave_access)
        rights = authority.draw_up()
        vocabularies = VocabularyHolder(vocabulary)
        organiser = Organiser(
            authority.in_force,
            profiles,
            stops,
            self.access.state,
            rates=rates_of(settings, profiles, rights, time, parts.store.note),
            lease_idle_s=settings.lease_idle_s,
        )
        self.access.restore(memory, organiser)
        organiser.remember_fences({robot: fence for robot, (_, fence) in numbers.items()})
        container = Containers(
            vocabularies,
            parts.store,
            parts.clock,
            {robot: n for robot, (n, _) in numbers.items()},
            usual=self.preferences.usual,
        )
        for choice in memory.selected:
            container.restore_selection(choice.principal, choice.chat, choice.robot)
        linker = Linker(
            self.robots, stops, parts.latch, parts.clock, time.wall_ns, authority.in_force
        )
        self.rooms = Components(
            authoriser, organiser, container, linker, vocabularies, profiles, stops
        )
        self._leaves.insert(0, self._save_rates)
        self.authority = authority
        await self._set_up(memory)

    def _names(self, authoriser: Authoriser) -> CalendarNames:
        profiles, place_zone, preferences = self.profiles, self._settings.zone, self.preferences
        return CalendarNames(
            name_of=lambda principal: inert_words(authoriser.directory.name(principal)),
            shown_of=lambda robot: profiles[robot].shown,
            zone_of=lambda principal: preferences.of(principal).zone or place_zone,
        )

    def _speaking(self) -> tuple[ChatSender, Notifier]:
        """Make what speaks to people, and what it takes to stop robots and to say so."""
        parts, authoriser = self._parts, self.rooms.authoriser
        languages = ChatLanguages(catalogue, LANGUAGES, partial(whose, authoriser))
        self.languages = languages
        gone: Deferred[[Item, ChatGone], None] = Deferred(nobody_to_tell)
        self._chat_sender = chat_sender = ChatSender(
            self.rooms.container, parts.clock, gone, languages
        )
        self.outbox = Outbox(parts.store, parts.clock, parts.entropy, chat_sender)
        resuming = ResumeHandler(self.rooms)
        self.stop_lane = StopLane(
            self.rooms, parts.store, parts.clock, chat_sender, resuming, self.outbox
        )
        self.enforcer = PolicyEnforcer(
            self.authority, self.rooms, self.stop_lane, self.access.changes
        )
        self.archive = Archive(parts.clock)
        codes_in = self.access.codes_in
        self._messengers = recorded(parts, self.archive, self.rooms, codes_in)
        last = LastAccounts(authoriser.directory, self.access.note)
        reach = Notifier(authoriser, chat_sender, self._messengers, self.outbox, last)
        gone.bind(self._elsewhere(reach).gone)
        return chat_sender, reach

    async def _set_up(self, memory: Memory) -> None:
        """Put a pipeline through the rooms, and everything in its place beside it."""
        parts, time = self._parts, self.access.time
        chat_sender, reach = self._speaking()
        self.pipeline = self._pipeline(chat_sender, reach)
        self._ends.append(self._end_orders)
        self.kernel = kernel_of(self, parts, self._settings, memory, chat_sender, reach)
        self.features = Features(self.kernel)
        self._leaves.append(self.features.leave)
        self.record_watch = RecordMonitor(parts.store, parts.latch, parts.clock, self._warn)
        self._tell_of_robots()
        self.robot_adder = RobotProvisioning(self, parts, memory, self._robot_says)
        self.kernel.shared.robot_adder.provide(self.robot_adder)
        self._closes.append(self.robot_adder.close)
        settled, now_ns = self.pipeline.backlog.settled, time.wall_ns()
        programs = ProgramService(self.rooms, self.access.programs)
        for messenger in self._messengers:
            serve_programs(messenger, programs)
        await take_in(self._messengers, memory, parts.store, self.rooms, settled, now_ns)

    def _tell_admins(self, text: str, *, urgent: bool) -> None:
        self.kernel.reach.tell(self.kernel.admins(), text, urgent=urgent)

    def _warn(self, text: str) -> None:
        self._tell_admins(text, urgent=True)

    def _elsewhere(self, reach: Notifier) -> UndeliverableHandler:
        admins, directory = (
            partial(admins_of, self.rooms.organiser),
            self.rooms.authoriser.directory,
        )
        return UndeliverableHandler(reach, admins, directory.name)

    def _pipeline(self, chat_sender: ChatSender, reach: Notifier) -> Pipeline:
        """Make the way of an order, with everything that decides beside it."""
        parts, access, organiser = self._parts, self.access, self.rooms.organiser
        misuse = AbuseResponse(access, organiser, reach)

        def confirmation_of(resolver: Resolver) -> Confirmation:
            is_set_up = access.two_factor.is_set_up
            return Confirmation(organiser, reach, resolver, access.time, parts.entropy, is_set_up)

        hooks = PipelineHooks(
            confirmation_of=confirmation_of,
            stepped_up=access.two_factor.fresh,
            proof_used=misuse.proof_used,
            refused=misuse.refused,
            changes_late=lambda: access.changes.late,
            commands=self.rooms.vocabulary.commands,
        )
        return Pipeline(self.rooms, self.stop_lane, chat_sender, parts.clock, parts.face, hooks)

    async def _authority(self, authoriser: Authoriser, memory: Memory) -> PolicyService:
        """Make everybody known, of the record and of the configuration; return their rights."""
        parts, settings = self._parts, self._settings
        roles = remember(authoriser, memory)
        roles.update(
            await seed(settings.people, memory, authoriser, parts.store, parts.clock, parts.entropy)
        )
        authority = PolicyService(
            settings.rulebook,
            settings.profiles,
            parts.units,
            authoriser.keys.time,
            self.preferences.limits,
        )
        authority.restore(memory, roles)
        return authority

    async def _recover(self, memory: Memory) -> None:
        parts, linker = self._parts, self.rooms.linker
        assert self._chat_sender is not None  # noqa: S101 - made just before
        messengers, ends = {each.name: each for each in self._messengers}, self.pipeline.ends
        recovery = Recovery(parts.store, linker, self._chat_sender, parts.clock, messengers, ends)
        count = await recovery.settle(memory.unfinished, self.robots.__contains__)
        self.kernel.shared.in_doubt.provide(recovery.in_doubt)
        linker.watch_stopped()
        await self.features.recover()
        warn_of_thieves(parts.messengers, self._warn)
        self.outbox.restore(memory.facts, messengers, self.kernel.reach.dress)
        if doubt := len(recovery.in_doubt):
            log.warning("orders that the last run left under way: %d", doubt)
        if count > doubt:
            log.info("ends of orders that are told again: %d", count - doubt)

    async def run(self) -> None:
        """Listen on every messenger until one of them fails for good, or until cancelled.

        Raises:
            MessengerFault, ConfigurationError: From the messenger that failed.
        """
        self._listening = [
            asyncio.create_task(m.run(partial(self.pipeline.receive, m))) for m in self._messengers
        ]
        rates, parts = self.rooms.organiser.rates, self._parts
        maintenance = Maintenance(self.kernel, self.features, self._daily)
        keeping = [
            asyncio.create_task(self.features.run()),
            asyncio.create_task(maintenance.run()),
            asyncio.create_task(self.record_watch.run()),
            asyncio.create_task(save_now_and_then(rates, parts.store, parts.clock)),
        ]
        try:
            done, _ = await asyncio.wait(self._listening, return_when=asyncio.FIRST_EXCEPTION)
            for task in done:
                task.result()
        finally:
            for task in keeping:
                task.cancel()
            await self.features.close()
            await self._fall_deaf()

    async def _daily(self) -> None:
        store = self._parts.store
        retention = Retention(
            self._settings.keep,
            self.rooms.organiser.calendar,
            self.access.changes,
            store if isinstance(store, AuditStore) else None,
            self.access.time.wall_ns,
        )
        await self.features.each_day()
        await retention.forget()

    async def _fall_deaf(self) -> None:
        for task in self._listening:
            task.cancel()
        if self._listening:  # a claim on its way to the disk is waited for, within bounds
            await asyncio.wait(self._listening, timeout=DEAF_WITHIN_S)
            await self.pipeline.backlog.settled(DEAF_WITHIN_S)
        self._listening = []

    @property
    def quiet(self) -> bool:
        """Whether no order is under way, no stop is being measured and nothing is left to say."""
        told = self._chat_sender is None or self._chat_sender.quiet
        told = (
            told
            and self.features.quiet
            and self.pipeline.backlog.quiet
            and self.pipeline.cancels.quiet
        )
        return told and self.stop_lane.quiet and not len(self.pipeline.executor)

    def _robot_says(self, profile: Profile, text: str) -> None:
        """Bring a robot's own words to everybody who chose it, as inert text (Algorithm 8)."""
        said = f"{profile.shown}: {inert_text(text)}"
        for messenger, chat in self.pipeline.followers.of(profile.id):
            if self._chat_sender is not None:
                self._chat_sender.say(
                    OutgoingMessage(messenger, Outbound(chat=chat, text=said), about=profile.id)
                )

    async def close(self) -> None:
        """Fall deaf, bring robots to rest, write and tell outcomes, close. At most some seconds.

        A robot without an order begins at once, beside those whose orders have to end first: three
        drones that hover come down together.
        """
        begun_ns = self._parts.clock.monotonic_ns()
        await self._fall_deaf()
        for closing in reversed(self._closes):
            await closing()
        leaving = asyncio.create_task(self._write_down())  # before what may take too long
        ending = asyncio.create_task(self._end_running_orders(begun_ns))
        await asyncio.sleep(0)  # from here on no order begins
        idle = self._idle()
        await asyncio.gather(ending, *map(self._part, idle))
        await asyncio.gather(*map(self._part, tuple(self._opened)))
        await asyncio.wait((leaving,), timeout=HOLD_WITHIN_S)
        leaving.cancel()
        await self._parts.store.close()

    async def _part(self, robot: Robot) -> None:
        await robot.close()
        self._opened.remove(robot)

    def not_at_rest(self) -> list[Profile]:
        """Return whose adapter is not closed yet and has not measured rest."""
        presence = self.rooms.linker.presence
        return [r.profile for r in self._opened if presence(r.profile.id).at_rest is not True]

    async def hold(self, robots: Sequence[RobotId]) -> bool:
        """Latch robots that could not be waited for. Return whether the latch is on disk."""
        linker, latch = self.rooms.linker, self._parts.latch
        held = [(robot, linker.hold(robot)) for robot in robots]
        keeping = [asyncio.ensure_future(latch.write(r, n, latched=True)) for r, n in held]
        if keeping:
            await asyncio.wait(keeping, timeout=HOLD_WITHIN_S)
        return all(k.done() and not k.cancelled() and k.exception() is None for k in keeping)

    async def _write_down(self) -> None:
        """Keep what was only counted so far. Nobody is heard any more, so it is the last."""
        await asyncio.gather(*(leaving() for leaving in self._leaves))

    async def _save_rates(self) -> None:
        save(self.rooms.organiser.rates, self._parts.store)

    async def _leave_access(self) -> None:
        self._parts.store.note(self.access.time.mark())
        await self.access.leave()

    async def _end_running_orders(self, begun_ns: int) -> None:
        """End what is under way, and tell it in what is left of the time since ``begun_ns``."""
        for ending in self._ends:
            await ending()
        if self._chat_sender is not None:
            past_s = (self._parts.clock.monotonic_ns() - begun_ns) / 1e9
            await self._chat_sender.flush(min(FLUSH_S, max(FLUSH_AT_LEAST_S, TOLD_BY_S - past_s)))

    async def _end_orders(self) -> None:
        self.rooms.linker.pursuit.close()  # each adapter brings its robot to rest itself
        await asyncio.gather(self.pipeline.close(), self.stop_lane.close())

    def _idle(self) -> list[Robot]:
        """Return the robots that carry out nothing; none while a stop is being measured."""
        if not self._opened or not self.stop_lane.quiet:
            return []
        presence = self.rooms.linker.presence
        return [robot for robot in self._opened if not presence(robot.profile.id).doing]
