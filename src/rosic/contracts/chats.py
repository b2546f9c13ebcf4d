"""What a messenger may know of its chats: what they are worth, and which is private with whom."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

from rosic.core.message import Chat
from rosic.core.policy.roles import ASSURANCES, Assurance

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Address
    from rosic.core.message import Inbound


@runtime_checkable
class HasChatAssurance(Protocol):
    """Its chats are not all worth the same; see `chat_assurance_of`."""

    def chat_assurance(self, chat: Chat) -> Assurance:
        """Return what a chat is worth now, for what is said there by us."""


@runtime_checkable
class FindsPrivateChat(Protocol):
    """A private chat there has an id of its own; see `private_chat_of`."""

    def private_chat(self, account: str) -> Chat | None:
        """Return the private chat with an account; None while there is none."""


def private_chat_of(messenger: Messenger, address: Address) -> Chat:
    """Return where somebody is told something in private. A look-up.

    Where a platform gives a private chat the account's own id, it is that; also where there is no
    such chat yet: what is said there opens it, if a messenger can.
    """
    found = None
    if isinstance(messenger, FindsPrivateChat):
        found = messenger.private_chat(address.account)
    return found or Chat(address.platform, address.account)


def messenger_assurance(messenger: Messenger) -> Assurance:
    """Return what a messenger is worth as a whole; what is not known is taken for the worst."""
    return ASSURANCES.get(messenger.assurance, Assurance.PROVIDER_READABLE)


def assurance_of(messenger: Messenger, inbound: Inbound) -> Assurance:
    """Return what the way is worth that a message came: who else could have written it.

    Args:
        messenger: Received it.
        inbound: The message; where its messenger does not tell of each, all are worth the same.
    """
    return messenger_assurance(messenger) if inbound.assurance is None else inbound.assurance


def chat_assurance_of(messenger: Messenger, chat: Chat) -> Assurance:
    """Return what a chat is worth now: who else could read what we say there, or write in it.

    It is the least of what it is with each of those who are there. A look-up.
    """
    if isinstance(messenger, HasChatAssurance):
        return messenger.chat_assurance(chat)
    return messenger_assurance(messenger)
