"""What a method is, and the checks that many of them share."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from rosic.testing.telegram.refusals import ApiError, bad_request, forbidden, too_many
from rosic.testing.telegram.world import PRESENT, World

if TYPE_CHECKING:
    from rosic.testing.telegram.parameters import CallParameters, Signature
    from rosic.testing.telegram.state import Message, ServerChat, User

ADMINS = frozenset({"creator", "administrator"})


class Call(NamedTuple):
    """One call, checked and ready.

    Attributes:
        alive: Says whether the caller still waits for the answer.
    """

    method: str
    args: CallParameters
    alive: Callable[[], bool]


class ApiResult(NamedTuple):
    """A result with a `description`, which some methods add."""

    result: Any
    description: str


Result: TypeAlias = Any
Handler: TypeAlias = Callable[[World, Call], Result | Awaitable[Result]]


class Method(NamedTuple):
    """One method: what it takes, and what it does."""

    signature: Signature
    run: Handler


def chat_of(world: World, args: CallParameters) -> ServerChat:
    """Return the chat that `chat_id` names.

    Raises:
        ApiError: 400 chat not found, or 400 with `migrate_to_chat_id`
            (https://core.telegram.org/bots/api#responseparameters).
    """
    named = args.chat("chat_id")
    if named is None or named == "":
        raise bad_request("chat_id is empty")
    chat = _lookup(world, named)
    if chat is None:
        raise bad_request("chat not found")
    if chat.migrated_to is not None:
        raise bad_request(
            "group chat was upgraded to a supergroup chat", {"migrate_to_chat_id": chat.migrated_to}
        )
    return chat


def _lookup(world: World, named: int | str) -> ServerChat | None:
    """An @name finds public groups and channels only (https://core.telegram.org/bots/api#sendmessage)."""
    if isinstance(named, int):
        return world.state.chats.get(named)
    name = named.removeprefix("@").lower()
    public = (c for c in world.state.chats.values() if c.kind in {"supergroup", "channel"})
    return next((c for c in public if (c.username or "").lower() == name), None)


def present_in(world: World, args: CallParameters) -> ServerChat:
    """Return the chat, after checking that the bot is there.

    Raises:
        ApiError: 400 or 403. The wording is that of the published server.
    """
    chat = chat_of(world, args)
    if chat.kind == "private":
        if not _knows(world, world.state.users[chat.id]):
            raise bad_request("chat not found")
        return chat
    status = world.bot_status(chat)
    kind = chat.kind if chat.kind == "group" else f"{chat.kind} chat"
    if status == "kicked":
        raise forbidden(f"bot was kicked from the {kind if ' ' in kind else 'group chat'}")
    if status not in PRESENT:
        raise forbidden(f"bot is not a member of the {kind if ' ' in kind else 'group chat'}")
    return chat


def writable(world: World, args: CallParameters) -> ServerChat:
    """Return the chat, after checking that the bot may write there.

    A bot cannot begin a conversation
    (https://core.telegram.org/bots/features#what-features-do-bots-have, "bots can't start
    conversations").
    """
    chat = present_in(world, args)
    if chat.kind == "private":
        person = world.state.users[chat.id]
        if person.is_bot:
            raise forbidden("bot can't send messages to bots")
        if person.blocked:
            raise forbidden("bot was blocked by the user")
        if not person.started:
            raise forbidden("bot can't initiate conversation with a user")
    if world.bot_status(chat) == "restricted":
        raise bad_request("not enough rights to send text messages to the chat")
    if chat.kind == "channel" and world.bot_status(chat) not in ADMINS:
        raise bad_request("need administrator rights in the channel chat")
    return chat


def _knows(world: World, person: User) -> bool:
    """A person is known who has written to the bot, or is in a group with it."""
    if person.started or person.blocked or person.is_bot:
        return True
    return any(
        person.id in c.members and world.bot.id in c.members for c in world.state.chats.values()
    )


def require_admin(world: World, chat: ServerChat, refusal: str) -> None:
    """Raise a 400 unless the chat is private or the bot is an administrator there."""
    if chat.kind != "private" and world.bot_status(chat) not in ADMINS:
        raise bad_request(refusal)


def require_right(world: World, chat: ServerChat, right: str, refusal: str) -> None:
    """Raise a 400 unless the chat is private, or the bot an administrator with this right."""
    require_admin(world, chat, refusal)
    if right in chat.withheld.get(world.bot.id, ()):
        raise bad_request(refusal)


def message_of(world: World, args: CallParameters, chat: ServerChat, what: str) -> Message:
    """Return the message that `message_id` names; `what` is "message to edit" or the like."""
    if "message_id" not in args:
        raise bad_request("message identifier is not specified")
    message = world.find(chat.id, args.integer("message_id"))
    if message is None:
        raise bad_request(f"{what} not found")
    return message


def spend(world: World, call: Call, chat: ServerChat) -> None:
    """Count one message or edit against the limits.

    Raises:
        ApiError: 429 with `retry_after`; nothing was sent.
    """
    now_s = world.clock.now_s()
    if (early_s := world.limiter.impatient_s(chat.id, now_s)) > 0:
        world.journal.violation(
            call.method,
            f"chat {chat.id} was written to {early_s:.2f} s before retry_after was over",
        )
    wait_s = world.limiter.retry_after_s(chat.id, is_group=chat.kind != "private", now_s=now_s)
    if wait_s:
        world.limiter.told(chat.id, wait_s, now_s)
        raise too_many(wait_s)


def unsupported(world: World, call: Call, what: str) -> ApiError:
    """Write down that this server lacks something Telegram has, and return a refusal."""
    world.journal.violation(call.method, f"{what} is not supported by this server")
    return bad_request(f"{what} is not supported by this server")
