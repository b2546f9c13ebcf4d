"""What a conversation is worth: of each message, and of each chat."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

from rosic.core.policy.roles import ASSURANCES, Assurance

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Chat, Inbound


@runtime_checkable
class HasChatAssurance(Protocol):
    """Its chats are not all worth the same; see `chat_assurance_of`."""

    def chat_assurance(self, chat: Chat) -> Assurance:
        """Return what a chat is worth now, for what is said there by us."""


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
