"""``/signin``: a code for the page. ``/signout``: every browser that is signed in as me is not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

from rosic.core.hosts import is_this_machine
from rosic.core.i18n import filled, joined, said
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.message import ChatKind
from rosic.errors import NotPermitted
from rosic.gateway.commands import Reply
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.gateway.access_registry import AccessRegistry
    from rosic.gateway.commands import CommandContext, CommandRegistry

COMMANDS: Final = (
    Command(
        name="signin",
        aliases=("anmelden",),
        typed=said("/signin"),
        summary=said("Sign in on the page"),
        help=HelpEntry(HelpPage.SHARE, 105),
    ),
    Command(
        name="signout",
        aliases=("abmelden",),
        summary=said("Sign every browser out that is signed in as me"),
        page=HelpPage.SHARE,
    ),
)

NO_PAGE: Final = said("There is no page here. The operator can turn it on: [api] listen.")
PROGRAM: Final = said("A program signs in nowhere: it shows its key.")
IN_GROUP: Final = said("Write /signin to me alone: whoever reads the code signs in as you.")
CODE: Final = said(
    "Your code for the page: {code}\n"
    "Type it at {url}. It is good for 5 minutes, once. Whoever has it signs in as you, so show it "
    "to nobody; nobody here ever asks for it."
)
LINK: Final = said("Or open: {link}")
SIGNED_OUT: Final = said("Every browser that was signed in as you is signed out ({count}).")
NOBODY: Final = said("No browser is signed in as you.")


class SignInCommands:
    """The handler of signing in.

    Args:
        access: Knows sessions.
        page_url: Returns where the page is; None where there is none.
    """

    def __init__(self, access: AccessRegistry, page_url: Callable[[], str | None]) -> None:
        self._access, self._page_url = access, page_url

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("signin", self.sign_in, offered=self._is_there)
        commands.register("signout", self.sign_out)

    def _is_there(self) -> bool:
        return self._page_url() is not None

    async def sign_in(self, asked: CommandContext) -> Reply:
        """Give a code to somebody who asks in their own chat.

        Raises:
            NotPermitted: A program asks, or others read along.
            Expired: It was asked long ago.
        """
        check_command_fresh(asked.inbound, "/signin")
        if asked.caller.is_program:
            raise NotPermitted(PROGRAM)
        if asked.inbound.chat.kind is not ChatKind.PRIVATE:
            raise NotPermitted(IN_GROUP)
        if (url := self._page_url()) is None:
            return Reply(NO_PAGE)
        code = self._access.page_sessions.offer(asked.caller.principal).reveal()
        told = [filled(CODE, code=code, url=url)]
        if may_carry_code(url):
            told.append(filled(LINK, link=f"{url}/#code={code}"))
        return Reply(joined("\n", told))

    async def sign_out(self, asked: CommandContext) -> Reply:
        """End every session of somebody, at once."""
        ended = self._access.page_sessions.end_all(asked.caller.principal)
        if not ended:
            return Reply(NOBODY)
        await self._access.changes.take_away(ended)
        return Reply(filled(SIGNED_OUT, count=len(ended)))


def may_carry_code(url: str) -> bool:
    """Whether a link may carry a code: it is encrypted, or goes to this machine alone."""
    parts = urlsplit(url)
    return parts.scheme == "https" or is_this_machine(parts.hostname or "")
