"""Who is let in, with which rights, by whom, and how that ends."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.contracts.messenger import invite_link_of
from rosic.core.i18n import joined
from rosic.core.language import clean_name
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
from rosic.features.access.link_commands import AccountLinkCommands
from rosic.features.access.newcomer_chat import NewcomerChat
from rosic.features.access.profile_commands import AccountCommands, PendingRequests
from rosic.features.access.program_keys import ProgramKeyCommands
from rosic.features.access.revoke_lock import AccessNotices, RevokeLockCommands
from rosic.features.access.roles import RoleCommands
from rosic.features.access.second_factor import AUTHENTICATOR, SecondFactorCommands
from rosic.gateway.delivery.redaction import SecretRedaction
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.identity import PrincipalId
    from rosic.gateway.feature import Kernel

__all__ = ["AccessFeature", "setup"]

PROVIDES: Final = ("pending",)


class AccessFeature(Feature):
    """People and their rights.

    Attributes:
        admitting: Asks admins about newcomers.
        request_commands: Asks admins for rights that somebody lacks.
        granting: Gives rights for a while.
        notices: Tells whoever is concerned that somebody's access has changed.
        retracting: Takes away what held a secret.
    """

    def __init__(
        self,
        kernel: Kernel,
        admitting: ApprovalCommands,
        request_commands: AccessRequestCommands,
        granting: GrantCommands,
        notices: AccessNotices,
        retracting: SecretRedaction,
    ) -> None:
        self._messengers, self._facts = kernel.messengers, kernel.memory.facts
        self.admitting, self.request_commands = admitting, request_commands
        self.granting, self.notices, self.retracting = granting, notices, retracting

    async def recover(self) -> None:
        """Take away what earlier runs have left in chats."""
        self.retracting.begin(self._messengers, self._facts)

    async def each_minute(self) -> None:
        """Let go whoever waited for an answer for too long."""
        await self.admitting.lapse()
        await self.request_commands.lapse()

    async def close(self) -> None:
        """Take nothing away any more."""
        await self.retracting.close()


def setup(kernel: Kernel) -> AccessFeature:
    """Let people in, and let whoever may do so give them rights and take them back."""
    access, policy, pipeline = kernel.access, kernel.enforcer.policy, kernel.pipeline
    registry = _registry(kernel)
    admin_policy = AdminPolicy(registry)
    access.may_invite.bind(admin_policy.may_admit)
    notices = AccessNotices(registry, admin_policy)
    newcomer_chat = NewcomerChat(
        kernel.orders.chat_sender,
        kernel.messengers,
        kernel.clock,
        kernel.entropy,
        count=access.counters.count,
    )
    admitting = ApprovalCommands(
        registry,
        admin_policy,
        newcomer_chat,
        menu=pipeline.menu,
        forget=access.forget_newcomer,
    )
    joining = JoinHandler(
        registry,
        admin_policy,
        admitting,
        newcomer_chat,
        shown_as=lambda inbound: clean_name(inbound.shown_as),
        names_robot=lambda text: text.strip().casefold() in kernel.rooms.vocabulary.callees,
    )
    places = _places(kernel)
    granting = GrantCommands(registry, admin_policy, kernel.entropy, places.zone_of)
    kernel.shared.grants_ended.connect(granting.announce)
    request_commands = AccessRequestCommands(
        registry, admin_policy, access.access_requests, granting, places
    )
    pending = PendingRequests(admitting, request_commands)
    kernel.shared.pending.provide(pending)
    about = AccountCommands(
        registry,
        admin_policy,
        pending,
        slots=partial(_slots_of, kernel),
        zone_of=places.zone_of,
        shown=places.shown,
    )
    handlers = AccessCommands(
        about,
        admitting,
        RevokeLockCommands(registry, admin_policy, notices),
        InviteCommands(
            registry,
            admin_policy,
            [messenger.platform for messenger in kernel.messengers],
            link=invite_link_of,
        ),
        SecondFactorCommands(registry, admin_policy),
        AccountLinkCommands(registry, admin_policy, access.access_requests),
        granting,
        request_commands,
        RoleCommands(registry, admin_policy, policy.rolebook),
        ProgramKeyCommands(
            registry, admin_policy, access.programs, lambda: policy.rolebook.rulebook
        ),
    )
    register_access_commands(kernel.commands, handlers, pipeline.confirmation)
    pipeline.hooks.newcomer.bind(joining.take)
    reminding = ApprovalReminders(kernel.reach, admitting, request_commands)
    pipeline.hooks.outdated.connect(reminding.remind)
    retracting = registry.retracting
    return AccessFeature(kernel, admitting, request_commands, granting, notices, retracting)


def _registry(kernel: Kernel) -> AccessContext:
    access, enforcer = kernel.access, kernel.enforcer

    async def ended(_principal: PrincipalId) -> None:
        enforcer.enforce()

    return AccessContext(
        retracting=_retracting(kernel),
        authoriser=kernel.rooms.authoriser,
        enrolment=access.enrolment,
        links=access.links,
        keys=access.keys,
        locks=access.locks,
        two_factor=access.two_factor,
        security=access.security,
        grants_book=enforcer.policy.grants_book,
        changes=access.changes,
        reach=kernel.reach,
        clock=kernel.clock,
        rights=lambda: enforcer.policy.rights,
        ahead=access.ahead,
        ended=ended,
    )


def _retracting(kernel: Kernel) -> SecretRedaction:
    """Have what holds a secret taken out of chats once it is worth nothing."""
    access = kernel.access
    made = access.enrolment.invitations
    is_good = {
        INVITATION: lambda name: any(one.id == name for one in made.open()),
        AUTHENTICATOR: access.two_factor.is_setting_up,
    }
    retracting = SecretRedaction(kernel.clock, kernel.entropy, access.note, is_good)
    access.changes.after(retracting.look)
    return retracting


def _places(kernel: Kernel) -> RequestPlaces:
    rooms, profiles, naming = kernel.rooms, kernel.rooms.profiles, kernel.naming
    return RequestPlaces(
        vocabularies=rooms.vocabularies,
        naming=lambda asked, text: naming.robot_or_group(asked, "/ask", text),
        shown=lambda name: profiles[name].shown if name in profiles else name,
        zone_of=rooms.organiser.calendar.zone,
    )


def _slots_of(kernel: Kernel, principal: PrincipalId) -> Sequence[str]:
    """Return what somebody's account says of the times they have."""
    organiser, profiles = kernel.rooms.organiser, kernel.rooms.profiles
    now_ns = organiser.wall_ns()
    return [
        joined(": ", (profiles[slot.robot].shown, organiser.moment(principal, slot.start_ns)))
        for slot in organiser.calendar.of(principal)
        if slot.end_ns > now_ns and slot.robot in profiles
    ][:5]
