"""What somebody has shown and confirmed, besides who they are."""

from __future__ import annotations

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.roles import Assurance


class Grounds(msgspec.Struct, frozen=True, kw_only=True):
    """What counts for one request.

    Attributes:
        channel: What the conversation is worth.
        stepped_up: A second factor was shown lately, in this chat.
        confirmed: This very request was confirmed by a tap.
        second: Who else has agreed to this very request.
    """

    channel: Assurance = Assurance.PROVIDER_READABLE
    stepped_up: bool = False
    confirmed: bool = False
    second: PrincipalId | None = None


NOTHING = Grounds()
