"""What a gateway is made of once its rooms are set up, and the kernel of its features."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.containers import DataContext, data_context_of, folders_of
from rosic.app.people import named_in_file
from rosic.contracts.store import ContainerStore
from rosic.gateway.delivery.last_accounts import KIND as LAST_ACCOUNTS
from rosic.gateway.feature import (
    ErasureParticipants,
    Kernel,
    RobotAssessment,
    SharedParts,
    Site,
)
from rosic.gateway.handover import LeaseHandover
from rosic.gateway.order_services import OrderServices
from rosic.gateway.robot_argument import RobotArgument, RobotArgumentParts, RoomQueries

if TYPE_CHECKING:
    from rosic.app.features import Features
    from rosic.app.settings import GatewayParts, GatewaySettings
    from rosic.container.archive import Archive
    from rosic.container.preferences import PreferenceBook
    from rosic.contracts.robot import Robot
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway import Pipeline
    from rosic.gateway.access_registry import AccessRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.gateway.policy_service import PolicyEnforcer, PolicyService
    from rosic.gateway.robot_registry import RobotRegistry
    from rosic.gateway.stop import StopLane


class RunningGateway:
    """The rooms, the way through them, and the features.

    Attributes:
        pipeline, registry, rooms, stop_lane, robots: Made when the gateway opens.
        profiles: Of every robot; what the rooms look into, so that it grows for all of them.
        authority, enforcer, access, kernel, features, archive, preferences, languages: Likewise.
    """

    pipeline: Pipeline
    registry: RobotRegistry
    rooms: Components
    stop_lane: StopLane
    robots: dict[RobotId, Robot]
    profiles: dict[RobotId, Profile]
    authority: PolicyService
    enforcer: PolicyEnforcer
    access: AccessRegistry
    kernel: Kernel
    features: Features
    archive: Archive
    preferences: PreferenceBook
    languages: ChatLanguages


def kernel_of(
    gateway: RunningGateway,
    parts: GatewayParts,
    settings: GatewaySettings,
    memory: Memory,
    chat_sender: ChatSender,
    reach: Notifier,
) -> Kernel:
    """Gather what features are made from, and take the commands of the kernel's own."""
    rooms, pipeline, time = gateway.rooms, gateway.pipeline, gateway.access.time
    handover = LeaseHandover(rooms, pipeline.executor, gateway.stop_lane, reach, time)
    pipeline.hooks.commands.register("take", handover.take)
    pipeline.hooks.commands.register("end", handover.give_back)
    pipeline.cancels.also(pipeline.confirmation.withdraw)
    _follow_accounts(gateway, memory, reach)
    orders = OrderServices(
        pipeline.executor,
        gateway.stop_lane,
        handover,
        chat_sender,
        reach,
        parts.face,
        pipeline.ends,
    )
    naming = RobotArgumentParts(
        rooms.vocabularies, RoomQueries(rooms.organiser.visible, rooms.container.selected)
    )
    erasure = ErasureParticipants()
    erasure.join(records=reach.last_accounts.end_all)
    named = named_in_file(settings.people, memory, rooms.authoriser)
    return Kernel(
        rooms=rooms,
        pipeline=pipeline,
        orders=orders,
        access=gateway.access,
        enforcer=gateway.enforcer,
        preferences=gateway.preferences,
        robots=gateway.robots,
        containers=_containers(gateway, parts, settings, reach),
        archive=gateway.archive,
        folders=folders_of(gateway.profiles),
        clock=time,
        machine_clock=parts.clock,
        entropy=parts.entropy,
        store=parts.store,
        memory=memory,
        renderer=parts.renderer,
        interpreter=parts.interpreter,
        recorder=parts.recorder,
        site=Site(settings.place, settings.zone, settings.missions, named),
        naming=RobotArgument(naming),
        assessment=RobotAssessment(),
        shared=SharedParts(),
        erasure=erasure,
    )


def _follow_accounts(gateway: RunningGateway, memory: Memory, reach: Notifier) -> None:
    """Know where people were last, and let nothing come of what an account that is lost asked."""
    last = reach.last_accounts
    lost, changes = gateway.access.account_lost, gateway.access.changes
    last.restore(memory.facts.get(LAST_ACCOUNTS, ()))
    changes.keep(LAST_ACCOUNTS, last.apply)
    gateway.pipeline.hooks.met.connect(last.heard)
    lost.connect(last.forget_account)
    lost.connect(gateway.pipeline.confirmation.forget_account)

    def fall_silent(principal: PrincipalId, address: Address) -> None:
        """Bring an account that is lost no more of what robots say."""
        for place in reach.places_of(address):
            gateway.pipeline.followers.leave(place.messenger.name, place.chat.id, principal)

    lost.connect(fall_silent)


def _containers(
    gateway: RunningGateway, parts: GatewayParts, settings: GatewaySettings, reach: Notifier
) -> ContainerContext | None:
    """Return what is kept in containers; None if the record cannot look into them."""
    if not isinstance(parts.store, ContainerStore):
        return None
    rooms = gateway.rooms
    around = DataContext(
        gateway.preferences,
        gateway.access,
        rooms.authoriser,
        rooms.organiser,
        rooms.profiles,
        rooms.vocabularies,
        parts.clock,
        reach.tell,
        gateway.pipeline.command_history,
    )
    return data_context_of(around, parts.store, gateway.archive, parts, settings.room)
