"""What the pretended Telegram knows: people, chats, messages, files and the queue of one bot.

Records, so that the whole state can be written to a file and read back (`--state`). Objects
that only travel (entities, keyboards, origins) stay the JSON objects they are on the wire.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import msgspec

JsonObject: TypeAlias = dict[str, Any]

ANONYMOUS_ADMIN_ID = 1087968824
"""Sender of what an anonymous group admin writes (https://core.telegram.org/bots/api#message)."""
CHANNEL_BOT_ID = 136817688
"""Sender of what is written in the name of a channel. Telegram's docs are silent on the number."""
SERVICE_ID = 777000
"""Sender of posts of the linked channel, forwarded into its discussion group by Telegram itself."""


class User(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One account.

    Attributes:
        started: This person has opened the private chat with the bot; before that the bot may not
        write.
        blocked: This person has blocked the bot.
    """

    id: int
    first_name: str
    last_name: str | None = None
    username: str | None = None
    language_code: str | None = None
    is_bot: bool = False
    started: bool = False
    blocked: bool = False

    def start(self) -> None:
        """Open the private chat with the bot."""
        self.started = True

    def block(self, *, blocked: bool) -> None:
        """Block the bot, or unblock it."""
        self.blocked = blocked

    def speak(self, language_code: str) -> None:
        """Use the app in another language from now on."""
        self.language_code = language_code


class ServerChat(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One chat.

    Attributes:
        kind: "private", "group", "supergroup" or "channel".
        members: Status by user id: "creator", "administrator", "member", "restricted", "left",
        "kicked".
        topics: Names of forum topics by thread id.
        topics_by: Who created each.
        instance: The `chat_instance` of button presses here.
        withheld: Rights that an administrator was not given, by user id.
        last_bot_id: The bot that wrote last; in privacy mode a bare `/command` goes to that one.
    """

    id: int
    kind: str
    title: str | None = None
    username: str | None = None
    members: dict[int, str] = {}
    topics: dict[int, str] = {}
    topics_by: dict[int, int] = {}
    is_forum: bool = False
    linked_chat_id: int | None = None
    migrated_to: int | None = None
    pinned: list[int] = []
    instance: str = ""
    withheld: dict[int, list[str]] = {}
    last_bot_id: int | None = None

    def add_topic(self, thread_id: int, name: str, user: int | None) -> None:
        """Have one more topic, and so be a forum; somebody may have created it."""
        self.is_forum = True
        self.topics[thread_id] = name
        if user is not None:
            self.topics_by[thread_id] = user

    def link_to(self, chat_id: int) -> None:
        """Belong to a channel as its discussion group, or the other way round."""
        self.linked_chat_id = chat_id

    def migrate_to(self, chat_id: int) -> None:
        """End here, and go on in a supergroup."""
        self.migrated_to = chat_id

    def hear_bot(self, bot_id: int) -> None:
        """Remember which bot wrote last."""
        self.last_bot_id = bot_id


class Content(msgspec.Struct, kw_only=True, omit_defaults=True):
    """The part of a message that an edit can change.

    Attributes:
        text: Of a text message; a message with media has a caption instead.
        media: The `photo` or `document` field as Telegram shows it, under its own name.
        received_s: Server time of the call or act that made it, in seconds with a fraction.
    """

    text: str | None = None
    entities: list[JsonObject] = []
    caption: str | None = None
    caption_entities: list[JsonObject] = []
    media: JsonObject = {}
    reply_markup: JsonObject | None = None
    received_s: float = 0.0


class Message(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One message, with every form it ever had.

    Attributes:
        date: Unix time in whole seconds, as Telegram dates it.
        versions: Oldest first; the last one is what the person sees now.
        own: The bot sent it; in a channel, nobody is named as its sender.
        extra: Further fields of Telegram's Message (origin, via_bot, service fields), as they are.
    """

    chat_id: int
    message_id: int
    date: int
    versions: list[Content]
    from_id: int | None = None
    sender_chat_id: int | None = None
    edit_date: int | None = None
    reply_to: int | None = None
    thread_id: int | None = None
    deleted: bool = False
    silent: bool = False
    own: bool = False
    reactions: dict[int, list[str]] = {}
    extra: JsonObject = {}

    @property
    def content(self) -> Content:
        """What the person sees now."""
        return self.versions[-1]

    def edit(self, version: Content, date: int) -> None:
        """Look otherwise from now on."""
        self.versions.append(version)
        self.edit_date = date

    def delete(self) -> None:
        """Be seen by nobody any more."""
        self.deleted = True


class ButtonPress(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One press of a button, and what the bot answered.

    Attributes:
        answers: Each with text, show_alert, url, cache_time and time_s.
    """

    id: str
    user_id: int
    chat_id: int
    message_id: int
    data: str
    pressed_s: float
    answers: list[JsonObject] = []


class ServerFile(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One file held by Telegram.

    Attributes:
        path: What getFile gives as `file_path`.
        show: The Document or PhotoSize object, without its content.
        left: Where a large file of a local server lies; then ``content`` is empty.
        link_until_s: Server time until which it can be downloaded; 0 before getFile.
    """

    id: str
    unique_id: str
    name: str
    path: str
    kind: str
    content: bytes
    show: JsonObject
    left: str = ""
    link_until_s: float = 0.0

    def swap(self, content: bytes) -> None:
        """Hold something else than was said of it."""
        self.content = content

    def open_link(self, until_s: float) -> None:
        """Let it be downloaded until then, in server time."""
        self.link_until_s = until_s


class Pending(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One update that waits for the bot.

    Attributes:
        expires_s: Server time after which Telegram forgets it.
    """

    update_id: int
    kind: str
    payload: JsonObject
    expires_s: float


MOST_CONNECTIONS = 40
"""Of a webhook, where none are named (https://core.telegram.org/bots/api#setwebhook)."""


class Webhook(msgspec.Struct, kw_only=True, omit_defaults=True):
    """The webhook as set; an empty `url` means none."""

    url: str = ""
    max_connections: int = MOST_CONNECTIONS
    ip_address: str | None = None

    def set(self, url: str, max_connections: int, ip_address: str | None) -> bool:
        """Be called there from now on; return whether that is another place than before."""
        moved = url != self.url
        self.url, self.max_connections, self.ip_address = url, max_connections, ip_address
        return moved

    def remove(self) -> bool:
        """Be called no more; return whether there was one."""
        return self.set("", MOST_CONNECTIONS, None)

    def redirect(self, url: str) -> None:
        """Be called elsewhere, with all else as it was."""
        self.url = url


class State(msgspec.Struct, kw_only=True, omit_defaults=True):
    """Everything that outlives a restart of the server.

    Attributes:
        counters: Last message id by chat; 0 stands for private chats and basic groups, which share
        one.
        allowed: Update types that are kept; None is Telegram's default selection.
        commands: By scope and language, as `setMyCommands` left them.
        names: `name`, `description`, `short_description` by kind and language.
    """

    bot: User
    users: dict[int, User] = {}
    chats: dict[int, ServerChat] = {}
    messages: dict[int, dict[int, Message]] = {}
    counters: dict[int, int] = {}
    queue: list[Pending] = []
    next_update_id: int = 100_000_001
    allowed: list[str] | None = None
    queries: dict[str, ButtonPress] = {}
    files: dict[str, ServerFile] = {}
    commands: dict[str, list[JsonObject]] = {}
    names: dict[str, str] = {}
    webhook: Webhook = msgspec.field(default_factory=Webhook)
    logged_out: bool = False
    serial: int = 0
    clock_shift_s: float = 0.0

    def next_serial(self) -> int:
        """Return a number never returned before."""
        self.serial += 1
        return self.serial

    def take_update_id(self) -> int:
        """Return the id of the next update."""
        update_id = self.next_update_id
        self.next_update_id += 1
        return update_id

    def renumber(self, next_update_id: int) -> None:
        """Go on with another update_id."""
        self.next_update_id = next_update_id

    def allow(self, kinds: list[str]) -> None:
        """Keep updates of these types from now on; an empty list is the default selection."""
        self.allowed = list(kinds) or None

    def log_out(self) -> None:
        """Let nothing work from now on."""
        self.logged_out = True
