"""What is sent and received of invitations, of who asks for a right, and of roles."""

from __future__ import annotations

from typing import Annotated

import msgspec

from rosic.api.schemas import Name

Words = Annotated[str, msgspec.Meta(max_length=300)]
"""One line, in words of the chat."""


class InvitationIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What an invitation shall give, in words of `/invite`.

    Attributes:
        rights: ``operator on kuka1 with speed <= 0.2 m/s for 2 hours``.
        name: How the newcomer shall be shown; empty: as their messenger says.
    """

    rights: Annotated[str, msgspec.Meta(min_length=1, max_length=300)]
    name: Annotated[str, msgspec.Meta(max_length=64)] = ""


class InvitationOut(msgspec.Struct, frozen=True):
    """An invitation that is open. Its code is told once, to whoever makes it.

    Attributes:
        gives: What it gives, as people read it.
        asks: Somebody who may has to let the newcomer in.
        own: The caller made it.
    """

    id: str
    gives: str
    by: str
    own: bool
    asks: bool
    expires: str


class InviteLinkOut(msgspec.Struct, frozen=True):
    """A link that opens a chat with us and hands the code in."""

    messenger: str
    url: str


class NewInvitationOut(msgspec.Struct, frozen=True):
    """A new invitation. What shows its code is told this once.

    Attributes:
        code: Whoever has it may come in.
        typed: What a newcomer types where no link can carry it.
        links: Of the messengers that have such links.
        qr: Picture of the first link, or else of what is typed: ``data:image/png;base64,...``.
        text: What the chat says.
    """

    invitation: InvitationOut
    code: str
    typed: str
    links: tuple[InviteLinkOut, ...]
    qr: str
    text: str


class RightsCheckIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line, and who would say it.

    Attributes:
        person: Name, or id.
        line: ``kuka1 grasp force=30``.
    """

    person: Name
    line: Annotated[str, msgspec.Meta(min_length=1, max_length=1_000)]


class RightsDecisionOut(msgspec.Struct, frozen=True):
    """What would be decided of one robot; nothing was done.

    Attributes:
        allowed: It would not be refused; the text says what would have to come first.
        text: The verdict, and every rule that was asked, a line each.
    """

    allowed: bool
    text: str


class AccessRequestIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A right that somebody lacks, for a while.

    Attributes:
        robot: Id, or a group's name.
        right: A skill, or a role.
        minutes: For how long.
    """

    robot: Name
    right: Name
    minutes: Annotated[int, msgspec.Meta(ge=1, le=10_080)]


class AccessRequestOut(msgspec.Struct, frozen=True):
    """Somebody waits for an answer.

    Attributes:
        kind: ``newcomer``, who wants to be let in, or ``right``.
        who: Their name.
        what: They would be given, as people read it.
        words: The two words that a newcomer sees, too: compare them before letting anybody in.
        own: The caller asks; others answer.
    """

    id: str
    kind: str
    who: str
    what: str
    words: str
    own: bool
    until: str


class AllowIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A yes.

    Attributes:
        minutes: For so long instead of what was asked for; 0: as asked.
    """

    minutes: Annotated[int, msgspec.Meta(ge=0, le=10_080)] = 0


class RoleOut(msgspec.Struct, frozen=True):
    """A role: a name for rights.

    Attributes:
        scopes: ``omni:move``, ``*:read``.
        includes: Other roles.
        limits: Hold for everything it gives.
        own: It was made here; others are of the configuration and cannot be changed.
    """

    name: str
    scopes: tuple[str, ...]
    includes: tuple[str, ...]
    limits: tuple[str, ...]
    own: bool


class RoleIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a role shall give, in words of `/role`: ``omni:move, viewer with speed <= 0.2 m/s``."""

    gives: Annotated[str, msgspec.Meta(min_length=1, max_length=300)]


class GrantIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What somebody shall be given, in words of `/grant`: ``operator on kuka1 for 2 hours``."""

    rights: Annotated[str, msgspec.Meta(min_length=1, max_length=300)]
