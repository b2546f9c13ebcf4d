"""Says who receives what: errands, newcomers, confirmations. The last step of putting together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.access import admins_of
from rosic.app.alert_feature import AlertFeature
from rosic.app.fleet_feature import BenchmarkContext as Askers
from rosic.app.fleet_feature import FleetFeature, furnish_benchmarks, show_benchmarks
from rosic.authoriser.invite_codes import telegram_link
from rosic.contracts.messenger import bot_name_of
from rosic.core.i18n import joined
from rosic.core.language import clean_name
from rosic.core.message import Outbound
from rosic.core.policy.scope import FLEET
from rosic.features.access.access_request import AccessRequestCommands
from rosic.features.access.access_request_parser import RequestPlaces
from rosic.features.access.admin_policy import AdminPolicy
from rosic.features.access.approve import ApprovalCommands
from rosic.features.access.commands import AccessCommands, hire
from rosic.features.access.context import AccessContext
from rosic.features.access.grant import GrantCommands
from rosic.features.access.invite import INVITATION, InviteCommands
from rosic.features.access.join import JoinHandler
from rosic.features.access.newcomer_chat import NewcomerChat
from rosic.features.access.profile_commands import AccountCommands
from rosic.features.access.reminding import ApprovalReminders
from rosic.features.access.revoke_lock import AccessNotices, RevokeLockCommands
from rosic.features.access.roles import RoleCommands
from rosic.features.access.second_factor import AUTHENTICATOR, SecondFactorCommands
from rosic.features.booking.commands import employ_clerks
from rosic.features.booking.context import BookingContext, BookingQueries
from rosic.features.booking.scheduler import BookingScheduler
from rosic.features.dashboard.commands import DashboardCommands
from rosic.features.dashboard.dashboard import RobotSnapshots
from rosic.features.dashboard.dashboards import Dashboards
from rosic.features.dashboard.rendering import DashboardQueries as CardSides
from rosic.features.fleet.by_rule import RuleTasks
from rosic.gateway.delivery.redaction import SecretRedaction
from rosic.gateway.delivery.sender import OutgoingMessage
from rosic.gateway.handover import LeaseHandover
from rosic.gateway.order_services import OrderServices
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.app.access import AccessFeature
    from rosic.app.policy import PolicyEnforcer, PolicyService
    from rosic.app.settings import GatewaySettings
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.order_status import Face
    from rosic.core.records import Memory
    from rosic.core.robot.profile import RobotId
    from rosic.core.secret import Secret
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.stop import StopLane


class FeatureSetup:
    """What stands beside the way of an order.

    Attributes:
        reach: Speaks to people who have not just asked.
        handover: Ends somebody's time with a robot.
        consent: Asks for confirmations.
        admitting: Asks admins about newcomers.
        notices: Tells whoever is concerned that somebody's access has changed.
        petitioning: Asks admins for rights that somebody lacks.
        granting: Gives rights for a while.
        keeper: Follows the calendar.
        live_cards: Shows in chats how robots are.
        fleet: Brings tasks to robots.
        retracting: Takes away what held a secret.
        judging: Follows robots against their benchmarks.
    """

    def __init__(
        self,
        rooms: Components,
        pipeline: Pipeline,
        access: AccessFeature,
        stop_lane: StopLane,
        teller: ChatSender,
        enforcer: PolicyEnforcer,
    ) -> None:
        self._rooms = rooms
        self._pipeline = pipeline
        self._access = access
        self._stop_lane = stop_lane
        self._teller = teller
        self._enforcer = enforcer

    def furnish(
        self,
        reach: Notifier,
        clock: Clock,
        entropy: Entropy,
        zone: str,
    ) -> None:
        """Put everything in its place.

        Args:
            reach: Speaks to people who have not just asked.
            clock: Of the gateway.
            entropy: Of the gateway.
            zone: Of the place, in which times are said to whoever has set no other.
        """
        rooms, reception = self._rooms, self._pipeline.reception
        self.reach, messengers = reach, reach.messengers
        self.handover = LeaseHandover(
            rooms, self._pipeline.lives, self._stop_lane, self.reach, clock
        )
        self.consent = self._pipeline.consent
        self._say_times_in(zone)
        self._pipeline.cancels.also(self.consent.withdraw)
        self._furnish_times(clock)
        self._furnish_people(self._enforcer.policy, messengers, clock, entropy)
        self._furnish_cards(messengers, clock)
        reception.office.employ("take", self.handover.take)
        reception.office.employ("end", self.handover.give_back)

    def alarms(
        self, memory: Memory, settings: GatewaySettings, clock: Clock, face: Face
    ) -> AlertFeature:
        """Return what follows the rules about alarms, as the record left them; tasks likewise."""
        lives, ends = self._pipeline.lives, self._pipeline.ends
        hands = OrderServices(
            lives, self._stop_lane, self.handover, self._teller, self.reach, face, ends
        )
        alarms = AlertFeature(self._rooms, self._access, clock, hands)
        alarms.furnish(self._pipeline, memory, settings.people)
        self.fleet = FleetFeature(self._rooms, self._access.changes, clock, hands)
        self.fleet.furnish(self._pipeline, memory, settings)
        alarms.running.tasks = RuleTasks(self._rooms, self.fleet.dispatching)
        self.judging = furnish_benchmarks(self._rooms, self._access, self._pipeline, memory, clock)
        asking = Askers(alarms.alerting, self._glimpses, self._naming)
        show_benchmarks(self.judging, self._rooms, self._pipeline, asking)
        self.fleet.show_on_cards(self.live_cards, self._card_sides, self._pipeline, memory)
        return alarms

    async def close(self) -> None:
        """Follow nothing any more; wait for robots that come to rest, briefly."""
        await self.keeper.close()
        await self.live_cards.close()
        await self.fleet.close()
        await self.retracting.close()
        await self.judging.settings.written()

    # ---- people ----

    def _furnish_people(
        self,
        authority: PolicyService,
        messengers: Sequence[Messenger],
        clock: Clock,
        entropy: Entropy,
    ) -> None:
        access, profiles = self._access, self._rooms.profiles

        async def ended(_principal: PrincipalId) -> None:
            self._enforcer.enforce()

        self._mind_secrets(clock, entropy)
        registry = AccessContext(
            retracting=self.retracting,
            authoriser=self._rooms.authoriser,
            enrolment=access.enrolment,
            keys=access.keys,
            locks=access.locks,
            stepup=access.stepup,
            security=access.security,
            roster=authority.roster,
            changes=access.changes,
            reach=self.reach,
            clock=clock,
            rights=lambda: authority.rights,
            ahead=access.ahead,
            ended=ended,
        )
        powers = AdminPolicy(registry)
        access.may_invite.bind(powers.may_admit)
        self.notices = AccessNotices(registry, powers)
        doorstep = NewcomerChat(self._teller, messengers, clock, entropy, count=access.tally.count)
        self.admitting = ApprovalCommands(
            registry, powers, doorstep, menu=self._pipeline.menu, forget=access.forget_newcomer
        )
        joining = JoinHandler(
            registry,
            powers,
            self.admitting,
            doorstep,
            shown_as=lambda inbound: clean_name(inbound.shown_as),
            names_robot=self._names_robot,
        )
        places = RequestPlaces(
            vocabulary=self._rooms.vocabulary,
            naming=lambda asked, text: self._naming.robot_or_group(asked, "/ask", text),
            shown=lambda name: profiles[name].shown if name in profiles else name,
            zone_of=self._rooms.organiser.calendar.zone,
        )
        self.granting = GrantCommands(registry, powers, entropy, places.zone_of)
        self.petitioning = AccessRequestCommands(
            registry, powers, access.petitions, self.granting, places
        )
        self.rolemaking = RoleCommands(registry, powers, authority.rolebook)
        about = AccountCommands(
            registry,
            powers,
            self.admitting,
            slots=self._slots_of,
            zone_of=places.zone_of,
            shown=places.shown,
        )
        about.petitioning = self.petitioning
        clerks = AccessCommands(
            about,
            self.admitting,
            RevokeLockCommands(registry, powers, self.notices),
            InviteCommands(registry, powers, link=_link),
            SecondFactorCommands(registry, powers),
            self.granting,
            self.petitioning,
            self.rolemaking,
        )
        hire(self._pipeline.reception.office, clerks, self.consent)
        self._pipeline.reception.newcomer.bind(joining.take)
        reminding = ApprovalReminders(self.reach, self.admitting, self.petitioning)
        self._pipeline.reception.outdated.connect(reminding.remind)

    def _mind_secrets(self, clock: Clock, entropy: Entropy) -> None:
        """Have what holds a secret taken out of chats once it is worth nothing."""
        access = self._access
        made = access.enrolment.invitations
        is_good = {
            INVITATION: lambda name: any(one.id == name for one in made.open()),
            AUTHENTICATOR: access.stepup.is_setting_up,
        }
        self.retracting = SecretRedaction(clock, entropy, access.note, is_good)
        access.changes.after(self.retracting.look)

    def _names_robot(self, text: str) -> bool:
        return text.strip().casefold() in self._rooms.vocabulary.callees

    def _slots_of(self, principal: PrincipalId) -> Sequence[str]:
        organiser, linker = self._rooms.organiser, self._rooms.linker
        now_ns = organiser.wall_ns()
        return [
            joined(
                ": ",
                (
                    linker.profile(slot.robot).shown,
                    organiser.moment(principal, slot.start_ns),
                ),
            )
            for slot in organiser.calendar.of(principal)
            if slot.end_ns > now_ns and slot.robot in self._rooms.profiles
        ][:5]

    # ---- times ----

    def _furnish_times(self, clock: Clock) -> None:
        rooms, access = self._rooms, self._access
        organiser = rooms.organiser
        sides = BookingQueries(
            visible=organiser.visible,
            may_book=organiser.why_not_move,
            right_ends_ns=lambda *of: organiser.rights.moves_until_ns(*of),  # noqa: PLW0108 - replaced
            may_cancel_any=lambda who, _: organiser.rights.holds(
                who, FLEET, "slots", clock.wall_ns()
            ),
            selected=rooms.container.selected,
            zone_of=organiser.calendar.zone,
            lease=organiser.lease,
            ready=self._ready,
            barred=lambda robot: rooms.board.barred(robot),  # noqa: PLW0108 - replaced
            may_resume=self._pipeline.resuming.may,
            handover=self.handover.end,
            may_stay=lambda who, slot: self.handover.outranks(who, slot.principal, slot.robot),
        )
        times = BookingContext(
            calendar=organiser.calendar,
            waiting=access.waiting,
            wishes=access.wishes,
            vocabulary=rooms.vocabulary,
            changes=access.changes,
            reach=self.reach,
            clock=clock,
            sides=sides,
            lease_idle_s=organiser.lease_idle_s,
        )
        self._naming = RobotArgument(times)
        self.keeper = BookingScheduler(times)
        access.changes.after(self.keeper.look)
        access.changes.after(self._watch_ends)
        self._watch_ends()
        employ_clerks(self._pipeline.reception.office, times, self.keeper)

    def _ready(self, robot: RobotId) -> bool:
        stopped = self._rooms.board[robot].latched
        return not stopped and self._rooms.linker.presence(robot).online is not False

    def _watch_ends(self) -> None:
        """Hear of orders that end, but only while somebody waits for a robot."""
        waited_for = bool(self._access.waiting.wanted())
        self._pipeline.lives.after = self._order_ended if waited_for else None

    def _order_ended(self, robot: RobotId) -> None:
        if self._access.waiting.queue(robot):
            self.keeper.look()

    def _say_times_in(self, zone: str) -> None:
        organiser, linker = self._rooms.organiser, self._rooms.linker
        calendar = organiser.calendar
        calendar.name_of = organiser.name_of
        calendar.shown_of = lambda robot: linker.profile(robot).shown
        calendar.zone_of = lambda _principal: zone  # until people's own settings are known
        self._access.waiting.shown_of = calendar.shown_of
        organiser.moment = lambda who, at_ns: moment(at_ns, organiser.wall_ns(), calendar.zone(who))

    # ---- live cards ----

    def _furnish_cards(self, messengers: Sequence[Messenger], clock: Clock) -> None:
        rooms, pipeline = self._rooms, self._pipeline
        self._glimpses = glimpses = RobotSnapshots(rooms, pipeline.lives, pipeline.face)
        sides = self._card_sides = CardSides(
            sees=self._sees,
            name_of=rooms.organiser.name_of,
            shown=lambda robot: rooms.profiles[robot].shown,
            face=pipeline.face,
            tell=lambda messenger, chat, text: self._teller.say(
                OutgoingMessage(messenger, Outbound(chat=chat, text=text))
            ),
            catalogue=self._teller.languages.of,
            issue=rooms.authoriser.buttons.issue,
        )
        self.live_cards = Dashboards(glimpses, self._access.changes, messengers, clock, sides)
        self.live_cards.restore(self._access.cards)
        clerk = DashboardCommands(self.live_cards, glimpses, rooms.vocabulary, sides)
        pipeline.reception.office.employ("card", clerk.card)

    def _sees(self, principal: PrincipalId) -> frozenset[RobotId]:
        """Return what somebody may see now who is not asking: they must be able to ask."""
        organiser = self._rooms.organiser
        if principal in organiser.locked or self._access.keys.current(principal) is None:
            return frozenset()
        return organiser.visible(principal)

    def admins(self) -> tuple[PrincipalId, ...]:
        """Return who looks after people here."""
        return admins_of(self._rooms.organiser)


def _link(messenger: Messenger, code: Secret) -> str:
    """Return the link that brings a code to a bot; empty on a messenger without such links."""
    bot = bot_name_of(messenger)
    return telegram_link(bot, code) if bot else ""
