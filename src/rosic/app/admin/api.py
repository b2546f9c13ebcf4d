"""What the operator's interface looks into: the rooms of a running gateway, or the data alone."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Annotated, NamedTuple

import msgspec

from rosic.core.language import clean
from rosic.core.policy.roles import ASSURANCES, Assurance
from rosic.errors import OutOfBounds
from rosic.features.access import AccessFeature
from rosic.features.personal_data import PersonalDataFeature
from rosic.features.verification import VerificationFeature
from rosic.organiser.calendar_messages import moment
from rosic.organiser.timezones import UNIVERSAL, Zone, zone_named

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.app.gateway import Gateway
    from rosic.authoriser.authoriser import Authoriser
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Principal, PrincipalId
    from rosic.core.language import Vocabulary, VocabularyHolder
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.features.access.revoke_lock import AccessNotices
    from rosic.features.personal_data.erasure import ErasureCommands
    from rosic.features.verification.service import DeviceVerifications
    from rosic.gateway.access_registry import AccessRegistry
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.policy_service import PolicyService
    from rosic.organiser.organiser import Organiser


# ---- what is looked into ----


class AdminContext(NamedTuple):
    """Everything that an operator may ask about or change.

    Attributes:
        zone: Of the place; times are told in it.
        assurances: What a conversation on each platform is worth.
        messengers: Those by which an invitation may be handed in; none while no gateway runs.
        notices: Tells people in their chats; None: no gateway runs, so nobody can be told.
        data_context: What is kept in containers; None: the record cannot look into them.
        erasing: Erases somebody; None while no gateway runs.
        verifications: Of people's devices; None while no gateway runs.
    """

    access: AccessRegistry
    authority: PolicyService
    authoriser: Authoriser
    organiser: Organiser
    vocabularies: VocabularyHolder
    profiles: Mapping[RobotId, Profile]
    clock: Clock
    zone: Zone
    assurances: Mapping[str, Assurance]
    messengers: Sequence[Messenger] = ()
    notices: AccessNotices | None = None
    data_context: ContainerContext | None = None
    erasing: ErasureCommands | None = None
    verifications: DeviceVerifications | None = None

    @property
    def vocabulary(self) -> Vocabulary:
        """What can be said now; not to be kept, as it may be replaced."""
        return self.vocabularies.current

    def name(self, principal: PrincipalId) -> str:
        """Return how somebody is shown."""
        return clean(self.authoriser.directory.name(principal))

    def shown(self, robot: RobotId) -> str:
        """Return how a robot is shown."""
        profile = self.profiles.get(robot)
        return robot if profile is None else profile.shown

    def moment(self, at_ns: int) -> str:
        """Return a time as it is said here today."""
        return moment(at_ns, self.clock.wall_ns(), self.zone)

    def assurance_of(self, person: Principal) -> Assurance:
        """Return what a private chat with somebody is worth; what is not known, the least.

        Of several accounts it is that of the least worth: an order may come by any of them.
        """
        platforms = [address.platform for address in person.addresses]
        known = (self.assurances.get(platform) for platform in platforms)
        return min((a for a in known if a is not None), default=Assurance.PROVIDER_READABLE)


def books_of(
    gateway: Gateway,
    zone: str,
    messengers: Sequence[Messenger] = (),
) -> AdminContext:
    """Return the books of a gateway that is open."""
    rooms, data = gateway.rooms, gateway.features.find(PersonalDataFeature)
    return AdminContext(
        access=gateway.access,
        authority=gateway.authority,
        authoriser=rooms.authoriser,
        organiser=rooms.organiser,
        vocabularies=rooms.vocabularies,
        profiles=rooms.profiles,
        clock=gateway.access.time,
        zone=zone_or_universal(zone),
        messengers=messengers,
        notices=gateway.features.get(AccessFeature).notices,
        data_context=gateway.kernel.containers,
        erasing=None if data is None else data.erasing,
        verifications=gateway.features.get(VerificationFeature).verifications,
        assurances={
            m.platform: ASSURANCES.get(m.assurance, Assurance.PROVIDER_READABLE) for m in messengers
        },
    )


def zone_or_universal(name: str) -> Zone:
    """Return a zone; UTC where this machine does not know it."""
    try:
        return zone_named(name)
    except OutOfBounds:
        return zone_named(UNIVERSAL)


# ---- requests ----

NOTHING = msgspec.Raw(b"null")


class AdminVerb(enum.Enum):
    """What may be asked."""

    STATUS = "status"
    STOP = "stop"
    RESUME = "resume"
    PEOPLE = "people"
    REVOKE = "revoke"
    INVITE = "invite"
    KEYS = "keys"
    CREATE_KEY = "create-key"
    ROTATE = "rotate-key"
    TAKE_KEY = "revoke-key"
    LOCK = "lock"
    UNLOCK = "unlock"
    EXPLAIN = "explain"
    SECURITY = "security"
    WHO = "who"
    TAKEN = "taken"
    BOOK = "book"
    CLOCK = "clock"
    CONTAINERS = "containers"
    CONTAINER = "container"
    CONTENT = "container-content"
    LIMIT = "limit-container"
    ERASE = "erase-container"
    ADD_ROBOT = "add-robot"
    HISTORY = "history"
    ATTACH = "attach"
    RECORD = "record"
    VERIFY = "verify"


class AnswerFormat(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How an answer is to be written.

    Attributes:
        json: For programs, with ids and times of UTC.
    """

    json: bool = False


ALL = "--all"
"""Every robot that is stopped, in place of names."""
AS_JSON = msgspec.Raw(msgspec.json.encode(AnswerFormat(json=True)))
"""The body of a request whose answers are for programs."""


class AdminRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One request; one connection carries one.

    Attributes:
        names: Robots, or a person; none means all.
        body: What else a verb asks for, as its own struct.
    """

    verb: AdminVerb
    names: Annotated[tuple[str, ...], msgspec.Meta(max_length=256)] = ()
    body: msgspec.Raw = NOTHING

    @property
    def wants_json(self) -> bool:
        """Whether the answers are for programs."""
        try:
            form = msgspec.json.decode(self.body, type=AnswerFormat | None)
        except msgspec.MsgspecError:
            return False
        return form is not None and form.json
