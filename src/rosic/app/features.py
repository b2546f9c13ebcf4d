"""Says who receives what: commands, newcomers, confirmations. The last step of putting together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.app.access import admins_of
from rosic.app.alert_feature import AlertFeature
from rosic.app.fleet_feature import FleetFeature
from rosic.contracts.messenger import invite_link_of
from rosic.core.i18n import joined
from rosic.core.language import clean_name
from rosic.core.message import Outbound
from rosic.core.policy.scope import FLEET
from rosic.features import benchmarks
from rosic.features.access.access_request import AccessRequestCommands
from rosic.features.access.access_request_parser import RequestPlaces
from rosic.features.access.admin_policy import AdminPolicy
from rosic.features.access.approval_reminders import ApprovalReminders
from rosic.features.access.approve import ApprovalCommands
from rosic.features.access.commands import AccessCommands, register_access_commands
from rosic.features.access.context import AccessContext
from rosic.features.access.grant import GrantCommands
from rosic.features.access.invite import INVITATION, InviteCommands
from rosic.features.access.join import JoinHandler
from rosic.features.access.newcomer_chat import NewcomerChat
from rosic.features.access.profile_commands import AccountCommands
from rosic.features.access.revoke_lock import AccessNotices, RevokeLockCommands
from rosic.features.access.roles import RoleCommands
from rosic.features.access.second_factor import AUTHENTICATOR, SecondFactorCommands
from rosic.features.booking.commands import register_commands
from rosic.features.booking.context import BookingContext, BookingQueries
from rosic.features.booking.scheduler import BookingScheduler
from rosic.features.dashboard.commands import DashboardCommands
from rosic.features.dashboard.dashboard import RobotSnapshots
from rosic.features.dashboard.dashboards import Dashboards
from rosic.features.dashboard.rendering import DashboardQueries as CardSides
from rosic.features.fleet.by_rule import RuleTasks
from rosic.gateway.delivery.redaction import SecretRedaction
from rosic.gateway.delivery.sender import OutgoingMessage
from rosic.gateway.feature import Kernel, RobotAssessment
from rosic.gateway.handover import LeaseHandover
from rosic.gateway.order_services import OrderServices
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.app.access import AccessFeature
    from rosic.app.policy import PolicyEnforcer, PolicyService
    from rosic.app.settings import GatewaySettings
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.order_status import Face
    from rosic.core.records import Memory
    from rosic.core.robot.profile import RobotId
    from rosic.features.dashboard.camera_preview import CameraPreview
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.feature import Feature
    from rosic.gateway.robot_registry import AddedRobot
    from rosic.gateway.stop import StopLane

# Made in this order, closed in reverse.
FEATURES: Final[tuple[Callable[[Kernel], Feature], ...]] = (benchmarks.setup,)


class FeatureSetup:
    """What stands beside the way of an order.

    Attributes:
        reach: Speaks to people who have not just asked.
        handover: Ends somebody's time with a robot.
        confirmation: Asks for confirmations.
        admitting: Asks admins about newcomers.
        notices: Tells whoever is concerned that somebody's access has changed.
        request_commands: Asks admins for rights that somebody lacks.
        granting: Gives rights for a while.
        scheduler: Follows the calendar.
        live_cards: Shows in chats how robots are.
        fleet: Brings tasks to robots.
        retracting: Takes away what held a secret.
        naming: Finds the robot that is meant at the beginning of a line.
        assessment: Says how robots do.
        plugged: The features that are made from the kernel alone.
    """

    def __init__(
        self,
        rooms: Components,
        pipeline: Pipeline,
        access: AccessFeature,
        stop_lane: StopLane,
        chat_sender: ChatSender,
        enforcer: PolicyEnforcer,
    ) -> None:
        self._rooms = rooms
        self._pipeline = pipeline
        self._access = access
        self._stop_lane = stop_lane
        self._chat_sender = chat_sender
        self._enforcer = enforcer
        self.assessment = RobotAssessment()

    def set_up(
        self,
        reach: Notifier,
        clock: Clock,
        entropy: Entropy,
        zone: str,
        memory: Memory,
        camera: CameraPreview | None,
    ) -> None:
        """Put everything in its place.

        Args:
            reach: Speaks to people who have not just asked.
            clock: Of the gateway.
            entropy: Of the gateway.
            zone: Of the place, in which times are said to whoever has set no other.
            memory: What earlier runs left.
            camera: Looks for the pictures of dashboards.
        """
        rooms, hooks = self._rooms, self._pipeline.hooks
        self.reach, messengers = reach, reach.messengers
        self.handover = LeaseHandover(
            rooms, self._pipeline.executor, self._stop_lane, self.reach, clock
        )
        self.confirmation = self._pipeline.confirmation
        self._say_times_in(zone)
        self._pipeline.cancels.also(self.confirmation.withdraw)
        self._set_up_times(clock)
        self._set_up_people(self._enforcer.policy, messengers, clock, entropy)
        self._set_up_cards(messengers, clock, camera)
        self.plugged = self._plug_in(memory, clock)
        hooks.commands.register("take", self.handover.take)
        hooks.commands.register("end", self.handover.give_back)

    def alarms(
        self, memory: Memory, settings: GatewaySettings, clock: Clock, face: Face
    ) -> AlertFeature:
        """Return what follows the rules about alarms, as the record left them; tasks likewise."""
        executor, ends = self._pipeline.executor, self._pipeline.ends
        hands = OrderServices(
            executor, self._stop_lane, self.handover, self._chat_sender, self.reach, face, ends
        )
        alarms = AlertFeature(self._rooms, self._access, clock, hands, self.assessment)
        alarms.set_up(self._pipeline, memory, settings.people)
        self.fleet = FleetFeature(self._rooms, self._access.changes, clock, hands)
        self.fleet.set_up(self._pipeline, memory, settings)
        alarms.running.tasks = RuleTasks(self._rooms, self.fleet.dispatching)
        self.fleet.show_on_cards(self.live_cards, self._card_sides, self._pipeline, memory)
        return alarms

    def _plug_in(self, memory: Memory, clock: Clock) -> tuple[Feature, ...]:
        kernel = Kernel(
            rooms=self._rooms,
            pipeline=self._pipeline,
            changes=self._access.changes,
            clock=clock,
            memory=memory,
            naming=self.naming,
            assessment=self.assessment,
        )
        return tuple(setup(kernel) for setup in FEATURES)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Tell every feature of one more robot."""
        for feature in self.plugged:
            feature.robot_added(newcomer)

    async def close(self) -> None:
        """Follow nothing any more; wait for robots that come to rest, briefly."""
        await self.scheduler.close()
        await self.live_cards.close()
        await self.fleet.close()
        await self.retracting.close()
        for feature in reversed(self.plugged):
            await feature.close()

    # ---- people ----

    def _set_up_people(
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
            two_factor=access.two_factor,
            security=access.security,
            grants_book=authority.grants_book,
            changes=access.changes,
            reach=self.reach,
            clock=clock,
            rights=lambda: authority.rights,
            ahead=access.ahead,
            ended=ended,
        )
        admin_policy = AdminPolicy(registry)
        access.may_invite.bind(admin_policy.may_admit)
        self.notices = AccessNotices(registry, admin_policy)
        newcomer_chat = NewcomerChat(
            self._chat_sender, messengers, clock, entropy, count=access.counters.count
        )
        self.admitting = ApprovalCommands(
            registry,
            admin_policy,
            newcomer_chat,
            menu=self._pipeline.menu,
            forget=access.forget_newcomer,
        )
        joining = JoinHandler(
            registry,
            admin_policy,
            self.admitting,
            newcomer_chat,
            shown_as=lambda inbound: clean_name(inbound.shown_as),
            names_robot=self._names_robot,
        )
        places = RequestPlaces(
            vocabularies=self._rooms.vocabularies,
            naming=lambda asked, text: self.naming.robot_or_group(asked, "/ask", text),
            shown=lambda name: profiles[name].shown if name in profiles else name,
            zone_of=self._rooms.organiser.calendar.zone,
        )
        self.granting = GrantCommands(registry, admin_policy, entropy, places.zone_of)
        self.request_commands = AccessRequestCommands(
            registry, admin_policy, access.access_requests, self.granting, places
        )
        self.rolemaking = RoleCommands(registry, admin_policy, authority.rolebook)
        about = AccountCommands(
            registry,
            admin_policy,
            self.admitting,
            slots=self._slots_of,
            zone_of=places.zone_of,
            shown=places.shown,
        )
        about.request_commands = self.request_commands
        handlers = AccessCommands(
            about,
            self.admitting,
            RevokeLockCommands(registry, admin_policy, self.notices),
            InviteCommands(registry, admin_policy, link=invite_link_of),
            SecondFactorCommands(registry, admin_policy),
            self.granting,
            self.request_commands,
            self.rolemaking,
        )
        register_access_commands(self._pipeline.hooks.commands, handlers, self.confirmation)
        self._pipeline.hooks.newcomer.bind(joining.take)
        reminding = ApprovalReminders(self.reach, self.admitting, self.request_commands)
        self._pipeline.hooks.outdated.connect(reminding.remind)

    def _mind_secrets(self, clock: Clock, entropy: Entropy) -> None:
        """Have what holds a secret taken out of chats once it is worth nothing."""
        access = self._access
        made = access.enrolment.invitations
        is_good = {
            INVITATION: lambda name: any(one.id == name for one in made.open()),
            AUTHENTICATOR: access.two_factor.is_setting_up,
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

    def _set_up_times(self, clock: Clock) -> None:
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
            vocabularies=rooms.vocabularies,
            changes=access.changes,
            reach=self.reach,
            clock=clock,
            sides=sides,
            lease_idle_s=organiser.lease_idle_s,
        )
        self.naming = RobotArgument(times)
        self.scheduler = BookingScheduler(times)
        access.changes.after(self.scheduler.look)
        access.changes.after(self._watch_ends)
        self._watch_ends()
        register_commands(self._pipeline.hooks.commands, times, self.scheduler)

    def _ready(self, robot: RobotId) -> bool:
        stopped = self._rooms.board[robot].latched
        return not stopped and self._rooms.linker.presence(robot).online is not False

    def _watch_ends(self) -> None:
        """Hear of orders that end, but only while somebody waits for a robot."""
        wanted = bool(self._access.waiting.wanted())
        self._pipeline.executor.hear_ends(self._order_ended, wanted=wanted)

    def _order_ended(self, robot: RobotId) -> None:
        if self._access.waiting.queue(robot):
            self.scheduler.look()

    def _say_times_in(self, zone: str) -> None:
        organiser, linker = self._rooms.organiser, self._rooms.linker
        calendar = organiser.calendar
        calendar.name_of = organiser.name_of
        calendar.shown_of = lambda robot: linker.profile(robot).shown
        calendar.zone_of = lambda _principal: zone  # until people's own settings are known
        self._access.waiting.shown_of = calendar.shown_of
        organiser.moment = lambda who, at_ns: moment(at_ns, organiser.wall_ns(), calendar.zone(who))

    # ---- live cards ----

    def _set_up_cards(
        self, messengers: Sequence[Messenger], clock: Clock, camera: CameraPreview | None
    ) -> None:
        rooms, pipeline = self._rooms, self._pipeline
        snapshots = RobotSnapshots(rooms, pipeline.executor, pipeline.face, self.assessment.line)
        sides = self._card_sides = CardSides(
            sees=self._sees,
            name_of=rooms.organiser.name_of,
            shown=lambda robot: rooms.profiles[robot].shown,
            face=pipeline.face,
            tell=lambda messenger, chat, text: self._chat_sender.say(
                OutgoingMessage(messenger, Outbound(chat=chat, text=text))
            ),
            catalogue=self._chat_sender.languages.of,
            issue=rooms.authoriser.buttons.issue,
        )
        self.live_cards = Dashboards(
            snapshots, self._access.changes, messengers, clock, sides, camera
        )
        self.live_cards.restore(self._access.cards)
        handler = DashboardCommands(self.live_cards, snapshots, rooms.vocabularies, sides)
        pipeline.hooks.commands.register("card", handler.card)

    def _sees(self, principal: PrincipalId) -> frozenset[RobotId]:
        """Return what somebody may see now who is not asking: they must be able to ask."""
        organiser = self._rooms.organiser
        if principal in organiser.locked or self._access.keys.current(principal) is None:
            return frozenset()
        return organiser.visible(principal)

    def admins(self) -> tuple[PrincipalId, ...]:
        """Return who looks after people here."""
        return admins_of(self._rooms.organiser)
