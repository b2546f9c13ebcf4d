"""``/mydata`` and ``/forget me``: what is kept about somebody, and ending it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.container import export
from rosic.container.files import PART
from rosic.core.message import Button
from rosic.errors import ConfigurationError, NotUnderstood, RecordUnavailable, StoreFault
from rosic.features.personal_data import messages as words
from rosic.features.personal_data.handing import handed_over
from rosic.gateway.builtin_commands import Reply
from rosic.gateway.office import check_private
from rosic.gateway.replies import LEAVE

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.features.personal_data.context import ContainerContext
    from rosic.features.personal_data.erasure import ErasureCommands
    from rosic.gateway.office import CommandContext

EXPORT = "export"
ME = frozenset({"me", "myself", "mich", "my data", "mydata"})
SURE = b"forget me"
FILE = "my-data"


class MyDataCommands:
    """The clerk of everybody's own container; answers nobody about another's (I11)."""

    def __init__(self, holdings: ContainerContext, erasing: ErasureCommands) -> None:
        self._holdings = holdings
        self._erasing = erasing

    async def my_data(self, asked: CommandContext) -> Reply:
        """Say what is kept, or show it.

        Raises:
            Refusal: Others read along, or it cannot be read now.
        """
        check_private(asked)
        verb, *forms = asked.rest.casefold().split() or [""]
        form = forms[0] if forms else "jsonl"
        if verb not in {"", EXPORT} or len(forms) > 1 or form not in export.ENDINGS:
            raise NotUnderstood(words.HOW_TO_FORGET, offers=("/mydata", f"/mydata {EXPORT}"))
        if verb == EXPORT:
            return await self._export(asked, form)
        found = await self._belongings(asked.caller.principal)
        row = (Button(words.EXPORT, f"/mydata {EXPORT}"), Button(words.FORGET, "/forget me"))
        count, size = self._holdings.files.used(asked.caller.principal)
        inside = (export.ContainerSummary(PART, count, size),) if count else ()
        return Reply(words.my_data((*export.summary(found), *inside)), (row,))

    async def _export(self, asked: CommandContext, form: str) -> Reply:
        command = f"{words.TO_EXPORT} {asked.caller.principal}"
        if form == "xlsx" and not asked.messenger.file_bytes:
            return Reply(words.spreadsheet_later(command))
        found = await self._belongings(asked.caller.principal)
        try:
            things = map(export.thing_of, found)
            made = await asyncio.to_thread(export.container_as, form, things)
        except ConfigurationError as missing:
            raise NotUnderstood(str(missing)) from missing
        return handed_over(asked, f"{FILE}.{export.ENDINGS[form]}", made, command)

    async def _belongings(self, principal: PrincipalId) -> tuple[Fact, ...]:
        try:
            return await self._holdings.vault.belongings(principal)
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault

    async def forget(self, asked: CommandContext) -> Reply:
        """Ask once, then erase whoever asks.

        Raises:
            Refusal: Others read along, somebody else is meant, the last admin, or it cannot be
                written.
        """
        check_private(asked)
        said, principal = " ".join(asked.rest.casefold().split()), asked.caller.principal
        if said in ME and asked.act == SURE:
            erased = await self._erasing.erase(principal, principal)
            return Reply(words.FORGOTTEN if erased.at_rest else words.FORGOTTEN_MOVING)
        if said not in ME:
            raise NotUnderstood(words.ONLY_ME if said else words.HOW_TO_FORGET)
        self._erasing.check(principal, principal)
        yes = Button(words.YES_FORGET, "/forget me", act=SURE)
        return Reply(words.SURE, ((yes,), (Button(words.LEAVE_IT, LEAVE),)))
