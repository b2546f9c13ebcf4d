"""Speaking with whoever is nobody yet: bound to their address, because there is nothing else."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

from rosic.authoriser.button_tokens import ButtonTokens
from rosic.contracts.chats import private_chat_of
from rosic.core.i18n import in_language
from rosic.core.message import Button, Outbound
from rosic.errors import Refusal
from rosic.features.access import messages
from rosic.gateway.delivery.sender import OutgoingMessage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.message import Inbound
    from rosic.core.secret import Secret
    from rosic.gateway.delivery.sender import ChatSender

JOIN, NOT_ME = "join", "not me"
OFFERED_AT_MOST = 2_000


class OfferedInvitation:
    """One invitation that was shown to an address.

    Attributes:
        code: None once one of its buttons was tapped: the other one is void from then on.
        issuer: Who invited.
        what: What the invitation gives, in words.
        invitation: Its id.
        good_for_ns: How much longer its code is good; its buttons are as long.
    """

    __slots__ = ("code", "good_for_ns", "invitation", "issuer", "what")

    def __init__(
        self, code: Secret, invitation: str, issuer: PrincipalId, what: str, good_for_ns: int
    ) -> None:
        self.code: Secret | None = code
        self.invitation = invitation
        self.issuer = issuer
        self.what = what
        self.good_for_ns = good_for_ns


class TappedInvitation:
    """A tap that counts.

    Attributes:
        code: To be handed in now; held by nothing else any more.
    """

    __slots__ = ("code", "joins", "offered")

    def __init__(self, offered: OfferedInvitation, code: Secret, *, joins: bool) -> None:
        self.offered = offered
        self.code = code
        self.joins = joins


class NewcomerChat:
    """Buttons for an address, and telling something to an address."""

    def __init__(
        self,
        chat_sender: ChatSender,
        messengers: Iterable[Messenger],
        clock: Clock,
        entropy: Entropy,
        *,
        count: Callable[[str], None],
    ) -> None:
        self._chat_sender = chat_sender
        self._messengers = tuple(messengers)
        self._buttons = ButtonTokens(clock, entropy, at_most=2 * OFFERED_AT_MOST, count=count)
        self._offered: OrderedDict[str, OfferedInvitation] = OrderedDict()

    def offer(self, inbound: Inbound, offered: OfferedInvitation) -> tuple[tuple[Button, ...], ...]:
        """Return the two buttons, good once, for this address in this chat alone."""
        said = ((messages.JOIN, JOIN), (messages.NOT_ME, NOT_ME))
        # Joining moves nothing, so it may come later than a tap that moves a robot.
        lasts_ns = offered.good_for_ns
        row = tuple(
            self._issue(inbound, offered, Button(label, what, good_for_ns=lasts_ns))
            for label, what in said
        )
        while len(self._offered) > 2 * OFFERED_AT_MOST:
            self._offered.popitem(last=False)
        return (row,)

    def _issue(self, inbound: Inbound, offered: OfferedInvitation, button: Button) -> Button:
        whose = stand_in(inbound.sender)
        issued = self._buttons.issue(button, whose, inbound.chat.id, still=True)
        self._offered[issued.nonce] = offered
        return issued

    def knows(self, nonce: str) -> bool:
        """Whether a button was shown to somebody who is not known yet; one look-up."""
        return nonce in self._offered

    def redeem(self, inbound: Inbound) -> TappedInvitation:
        """Return what a tap says, and void both buttons.

        Raises:
            Expired, NotPermitted: Too old, used already, or shown to somebody else.
        """
        nonce = inbound.nonce or ""
        offered = self._offered[nonce]
        said = self._buttons.redeem(nonce, stand_in(inbound.sender), inbound)
        code, offered.code = offered.code, None
        if code is None:
            raise Refusal(messages.ANSWERED)
        return TappedInvitation(offered, code, joins=said.command == JOIN)

    def is_settled(self, nonce: str) -> bool:
        """Whether one of the two buttons was tapped."""
        return self._offered[nonce].code is None

    def tell(self, address: Address, text: str) -> None:
        """Tell something in the private chat of an address, if its platform has one."""
        plain = in_language(text, self._chat_sender.languages.of_address(address))
        for messenger in self._messengers:
            if messenger.platform == address.platform:
                chat = private_chat_of(messenger, address)
                self._chat_sender.say(OutgoingMessage(messenger, Outbound(chat=chat, text=plain)))


def stand_in(address: Address) -> PrincipalId:
    """Return what stands where a principal would: no id of anybody looks like it."""
    return ascii((address.platform, address.account))
