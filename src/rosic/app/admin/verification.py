"""What the operator of this machine may do about somebody's devices: compare their emoji.

Nobody can put anything between a machine and whoever sits at it, so this is how the first one is
verified who then compares for others in a chat.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.app.admin.naming import the_one
from rosic.core.i18n import plain
from rosic.core.identity import OPERATOR
from rosic.errors import Expired, NotUnderstood
from rosic.features.verification import messages as words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.app.admin.api import AdminContext, AdminRequest
    from rosic.features.verification.service import DeviceVerifications

NOT_ONE: Final = "That is no request about verifying."
NONE_HERE: Final = "No messenger of this gateway has devices that can be verified."


class ShownEmoji(msgspec.Struct, frozen=True):
    """What is compared at the machine.

    Attributes:
        number: What it is named by.
        name, account, device: Whose it is.
        text: The emoji, with their names; empty: they have not accepted yet.
        outcome: How it ended; empty: it has not.
        verified: It ended well.
    """

    number: int
    name: str
    account: str
    device: str = ""
    text: str = ""
    outcome: str = ""
    verified: bool = False


class VerificationAdmin:
    """Answers ``begin NAME``, ``list``, ``show N``, ``match N`` and ``differ N``."""

    def __init__(self, books: AdminContext) -> None:
        self._books = books

    async def do(self, ask: AdminRequest) -> Iterable[str]:
        """Do what is asked, and return what is said or shown.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        verifications = self._books.verifications
        if verifications is None or not verifications.serves():
            raise NotUnderstood(NONE_HERE)
        verb, typed = (*ask.names, "", "")[:2]
        if verb == "list":
            return [self._shown(verifications, str(one.number)) for one in verifications.pending()]
        if verb == "begin":
            return (await self._begin(verifications, typed),)
        if verb == "show":
            return (self._shown(verifications, typed),)
        if verb not in {"match", "differ"}:
            raise NotUnderstood(NOT_ONE)
        if (pending := verifications.find(typed)) is None:
            raise Expired(words.ENDED)
        if verb == "differ":
            await verifications.reject(pending)
            return (words.SAID_DIFFERENT,)
        await verifications.confirm(pending, OPERATOR)
        return (words.SAID_SAME,)

    async def _begin(self, verifications: DeviceVerifications, name: str) -> str:
        person = the_one(self._books.authoriser.directory, name)
        pending = await verifications.begin_with(person)
        if pending is None:
            raise NotUnderstood(words.no_account(person.name))
        return self._shown(verifications, str(pending.number))

    def _shown(self, verifications: DeviceVerifications, number: str) -> str:
        pending = verifications.find(number)
        if pending is None and number.isdecimal():
            pending = verifications.ended(int(number))
        if pending is None:
            raise Expired(words.ENDED)
        code = pending.code
        shown = ShownEmoji(
            pending.number,
            verifications.name(pending),
            pending.account,
            "" if code is None else code.device,
            "" if code is None else code.text,
            plain(verifications.outcome(pending)),
            pending.is_verified,
        )
        return msgspec.json.encode(shown).decode()
