"""Groups and channels, for tests: making them, members coming and going, migration."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.testing.telegram import objects
from rosic.testing.telegram.refusals import ControlError
from rosic.testing.telegram.state import Content, JsonObject, Message, ServerChat
from rosic.testing.telegram.world import PRESENT, World

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


class Groups:
    """The control side's chats."""

    world: World

    def create_chat(
        self,
        kind: str,
        title: str,
        *,
        members: Sequence[int] = (),
        bot: str | None = "member",
        username: str | None = None,
        topics: Sequence[str] = (),
    ) -> int:
        """Make a group, supergroup or channel and return its id; the first member owns it.

        Args:
            kind: "group", "supergroup" or "channel".
            title: As shown.
            members: User ids.
            bot: The bot's status there, or None when it is not there.
            username: Of a public supergroup or channel.
            topics: Makes a forum with these topics.
        """
        if kind not in {"group", "supergroup", "channel"}:
            raise ControlError("kind is group, supergroup or channel")
        there = dict.fromkeys(members, "member")
        if members:
            there[members[0]] = "creator"
        chat = self._new_chat(kind, title, there, username)
        for name in topics:
            self.create_topic(chat.id, name, members[0] if members else None)
        if bot is not None:
            self.set_member(chat.id, self.world.bot.id, bot)
        return chat.id

    def create_topic(self, chat: int, name: str, user: int | None) -> int:
        """Add a topic, created by a person or a bot, and return its thread id. Nobody is told."""
        where = self.world.state.chats[chat]
        thread = self.world.new_message_id(where)
        where.add_topic(thread, name, user)
        return thread

    def topics(self, chat: int) -> dict[str, int]:
        """Return the thread ids of a forum's topics by name."""
        return {name: thread_id for thread_id, name in self.world.state.chats[chat].topics.items()}

    def set_member(
        self,
        chat: int,
        user: int,
        status: str,
        *,
        by: int | None = None,
        without: Sequence[str] = (),
    ) -> None:
        """Let somebody, or the bot, join, leave, be promoted, restricted or thrown out.

        https://core.telegram.org/bots/api#chatmemberupdated: `my_chat_member` for the bot itself;
        `chat_member` for others, only where the bot is an administrator and asked for it. Joining
        and leaving also leave a service message.

        Args:
            chat: Where.
            user: Who.
            status: As https://core.telegram.org/bots/api#chatmember has it.
            by: Who did it; the owner if nobody is named.
            without: Rights that an administrator is not given, such as "can_pin_messages".
        """
        where = self.world.state.chats[chat]
        old, who = where.members.get(user, "left"), self.world.state.users[user]
        withheld, where.withheld[user] = where.withheld.get(user, []), [*without]
        where.members[user] = status
        actor = by or next(iter(where.members))
        if (old in PRESENT) != (status in PRESENT) and where.kind != "channel":
            self._note_passage(where, user, actor, joined=status in PRESENT)
        update: JsonObject = {
            "chat": objects.chat(where, self.world.state),
            "from": objects.user(self.world.state.users[actor]),
            "date": self.world.clock.date(),
            "old_chat_member": objects.member(who, old, withheld),
            "new_chat_member": objects.member(who, status, without),
        }
        if user == self.world.bot.id:
            self._queue("my_chat_member", update)
        elif self.world.bot_status(where) == "administrator":
            self._queue("chat_member", update)

    def block(self, user: int, *, blocked: bool = True) -> None:
        """Let a person block the bot, or unblock it."""
        person = self.world.state.users[user]
        if person.blocked == blocked:
            return
        person.block(blocked=blocked)
        before, after = ("member", "kicked") if blocked else ("kicked", "member")
        update: JsonObject = {
            "chat": objects.chat(self.world.state.chats[user], self.world.state),
            "from": objects.user(person),
            "date": self.world.clock.date(),
            "old_chat_member": objects.member(self.world.bot, before),
            "new_chat_member": objects.member(self.world.bot, after),
        }
        self._queue("my_chat_member", update)

    def link(self, channel: int, group: int) -> None:
        """Make a supergroup the discussion group of a channel."""
        self.world.state.chats[channel].link_to(group)
        self.world.state.chats[group].link_to(channel)

    def migrate(self, group: int) -> int:
        """Turn a basic group into a supergroup and return the new id.

        https://core.telegram.org/bots/api#message (`migrate_to_chat_id`, `migrate_from_chat_id`).
        """
        old = self.world.state.chats[group]
        if old.kind != "group":
            raise ControlError("only a basic group becomes a supergroup")
        new = self._new_chat("supergroup", old.title or "", dict(old.members))
        self._note(old, next(iter(old.members)), {"migrate_to_chat_id": new.id})
        old.migrate_to(new.id)
        self._note(new, next(iter(old.members)), {"migrate_from_chat_id": old.id})
        return new.id

    def _new_chat(
        self, kind: str, title: str, members: dict[int, str], username: str | None = None
    ) -> ServerChat:
        number = self.world.serial()
        base = -4_000_000_000 if kind == "group" else -1_002_000_000_000
        instance = str(-4_611_686_018_427_387_000 + number)
        chat = ServerChat(
            id=base - number,
            kind=kind,
            title=title,
            username=username,
            members=members,
            instance=instance,
        )
        self.world.state.chats[chat.id] = chat
        return chat

    def _note_passage(self, where: ServerChat, user: int, actor: int, *, joined: bool) -> None:
        who = objects.user(self.world.state.users[user])
        self._note(
            where, actor, {"new_chat_members": [who]} if joined else {"left_chat_member": who}
        )

    def _note(self, where: ServerChat, actor: int, fields: Mapping[str, object]) -> None:
        """Write a service message."""
        if actor == self.world.bot.id:
            return
        message = self.world.keep(
            Message(
                chat_id=where.id,
                message_id=self.world.new_message_id(where),
                date=self.world.clock.date(),
                versions=[Content(received_s=self.world.clock.now_s())],
                from_id=actor,
                extra=dict(fields),
            )
        )
        self.world.announce(message)

    def _queue(self, kind: str, update: JsonObject) -> None:
        lifetime_s = self.world.settings.update_lifetime_s
        self.world.queue.put(kind, update, self.world.clock.now_s() + lifetime_s)
