"""What people do, for tests: writing, editing, pressing, reacting, sending files."""

from __future__ import annotations

from pathlib import Path
from typing import TypedDict, Unpack

from msgspec.structs import replace

from rosic.testing.telegram import entities, files, keyboards, objects
from rosic.testing.telegram.methods.chats import REACTIONS, plain_emoji
from rosic.testing.telegram.parameters import Upload
from rosic.testing.telegram.refusals import ControlError
from rosic.testing.telegram.spool import on_disk
from rosic.testing.telegram.state import (
    ANONYMOUS_ADMIN_ID,
    CHANNEL_BOT_ID,
    SERVICE_ID,
    ButtonPress,
    Content,
    JsonObject,
    Message,
    ServerChat,
    User,
)
from rosic.testing.telegram.world import PRESENT, World

MOST_REACTIONS = 3
"""Of one person with Premium, to one message; Telegram's docs name no number. Others have one."""


class MessageOptions(TypedDict, total=False):
    """Everything unusual about a message from a person.

    Attributes:
        date: Unix time to put on it instead of now; more than 24 h old, and the bot never hears of
        it.
        age_s: The same as a distance into the past.
        entities: Instead of those that Telegram finds in the text by itself.
        forward_origin: A user id, a hidden name, or a MessageOrigin object
            (https://core.telegram.org/bots/api#messageorigin).
        via_bot: Id of the inline bot it was written through; True is this bot.
        edit_of: Edit that message instead of writing a new one.
        sender_chat: The chat in whose name it is written: the group itself for an anonymous admin.
        reply_to: Id of the message it answers.
        thread: Id of the forum topic.
        extra: Any further fields of Telegram's Message, taken as they are.
    """

    date: int
    age_s: float
    entities: list[JsonObject]
    forward_origin: int | str | JsonObject
    via_bot: int | bool
    edit_of: int
    sender_chat: int
    reply_to: int
    thread: int
    extra: JsonObject


class People:
    """The control side's people. Ids are returned; what is not possible raises ControlError."""

    world: World

    def create_user(
        self,
        first_name: str,
        *,
        username: str | None = None,
        language_code: str = "en",
        is_bot: bool = False,
        started: bool = True,
    ) -> int:
        """Make an account, with its private chat.

        Args:
            first_name: As shown.
            username: Without the @.
            language_code: Of the app.
            is_bot: Another bot; this one never hears of what it writes.
            started: Whether the person has opened the chat with the bot, so that the bot may write.
        """
        number = 7_000_000_000 + self.world.serial()
        self.world.state.users[number] = User(
            id=number,
            first_name=first_name,
            username=username,
            language_code=language_code,
            is_bot=is_bot,
            started=started,
        )
        instance = str(-4_611_686_018_427_000_000 - number)
        self.world.state.chats[number] = ServerChat(id=number, kind="private", instance=instance)
        return number

    def set_language(self, user: int, language_code: str) -> None:
        """Let somebody's app speak another language from now on."""
        self.world.state.users[user].speak(language_code)

    def say(self, chat: int, user: int | None, text: str, **unusual: Unpack[MessageOptions]) -> int:
        """Write a message, as a person does, and return its id.

        Writing in the private chat starts it. In a channel nobody is named: `user` is None there.
        """
        if (edit_of := unusual.get("edit_of")) is not None:
            return self.edit(chat, edit_of, text, **unusual)
        marked = unusual.get("entities")
        content = Content(text=text, entities=entities.found(text) if marked is None else marked)
        return self._post(chat, user, content, unusual).message_id

    def edit(self, chat: int, message: int, text: str, **unusual: Unpack[MessageOptions]) -> int:
        """Edit a person's message, as a person does; the bot gets `edited_message`."""
        found = self._message(chat, message)
        if found.from_id == self.world.bot.id:
            raise ControlError("a person cannot edit the bot's message")
        marked = unusual.get("entities")
        version = Content(
            text=text,
            entities=entities.found(text) if marked is None else marked,
            received_s=self.world.clock.now_s(),
        )
        found.edit(version, self._date(unusual))
        self.world.journal.add("said", chat_id=chat, message_id=message, edited=True)
        self.world.announce(found, edited=True)
        return message

    def send_file(
        self,
        chat: int,
        user: int,
        name: str,
        content: bytes | Path,
        **unusual: Unpack[MessageOptions],
    ) -> int:
        """Send a document, or a photo when the content is a PNG or JPEG named .png or .jpg.

        What is given by its path is not copied: it stays there, a document.
        """
        kind = "application/octet-stream"
        if isinstance(content, Path):
            upload = Upload(name=name, content_type=kind, on_disk=on_disk(str(content)))
            content = b""
        else:
            upload = Upload(name=name, content_type=kind, content=content)
        size = files.image_size(content) if name.lower().endswith((".png", ".jpg")) else None
        if size is None:
            media: JsonObject = {"document": files.store_document(self.world, upload).show}
        else:
            media = {"photo": [files.store_photo(self.world, upload, size).show]}
        return self._post(chat, user, Content(media=media), unusual).message_id

    def swap_file(self, file_id: str, content: bytes) -> None:
        """Let a file hold something else than was said of it: a server that errs, or lies."""
        self.world.state.files[file_id].swap(content)

    def tap(
        self,
        user: int,
        chat: int,
        message: int,
        button: str,
        *,
        stale: bool = False,
        forged: bool = False,
    ) -> str:
        """Press a button, named by its text or its callback_data, and return the id of the press.

        A press has no date (https://core.telegram.org/bots/api#callbackquery).

        Args:
            user: Who presses.
            chat: Where.
            message: On which message.
            button: Its text or its callback_data.
            stale: Any earlier form of the message counts too: a phone that has not seen the edit.
            forged: Send `button` as callback_data whatever the message holds: "a bad client can
            send
                arbitrary data in this field".
        """
        found = self.world.state.messages.get(chat, {}).get(message)
        if found is None or (found.deleted and not stale):
            raise ControlError(f"there is no message {message} in chat {chat} to press on")
        self._require_present(self.world.state.chats[chat], user)
        data = button if forged else self._data_of(found, button, stale=stale)
        query = ButtonPress(
            id=str(5_000_000_000_000_000_000 + self.world.serial()),
            user_id=user,
            chat_id=chat,
            message_id=message,
            data=data,
            pressed_s=self.world.clock.now_s(),
        )
        self.world.state.queries[query.id] = query
        self.world.journal.add("pressed", query_id=query.id, chat_id=chat, message_id=message)
        self.world.queue.put(
            "callback_query",
            objects.callback_query(query, self.world.state),
            query.pressed_s + self.world.settings.press_lifetime_s,
        )
        return query.id

    def react(
        self, chat: int, user: int, message: int, *emoji: str, anonymous: bool = False
    ) -> None:
        """React to a message, or take every reaction back.

        https://core.telegram.org/bots/api#messagereactionupdated: only an administrator bot hears
        of it in a group, and none of the reactions of bots. In a channel nobody is named, and the
        bot hears numbers (https://core.telegram.org/bots/api#messagereactioncountupdated).

        Args:
            chat: Where.
            user: Who.
            message: To what.
            emoji: All of that person's reactions from now on; three at most, with Premium.
            anonymous: In the name of the group, as an anonymous administrator.
        """
        found, where = self._message(chat, message), self.world.state.chats[chat]
        self._require_present(where, user)
        if len(emoji) > MOST_REACTIONS or any(plain_emoji(one) not in REACTIONS for one in emoji):
            raise ControlError("no person can react like that")
        old = found.reactions.get(user, [])
        found.reactions[user] = list(emoji)
        self.world.journal.add("reacted", chat_id=chat, message_id=message, emoji=list(emoji))
        hears = where.kind == "private" or self.world.bot_status(where) == "administrator"
        if old == list(emoji) or not hears or self.world.state.users[user].is_bot:
            return
        kind, update = objects.reacted(found, self.world.state, user, old, anonymous=anonymous)
        update["date"] = self.world.clock.date()
        lifetime_s = self.world.settings.update_lifetime_s
        self.world.queue.put(kind, update, self.world.clock.now_s() + lifetime_s)

    def delete(self, chat: int, message: int) -> None:
        """Delete a message as a person; a bot is not told."""
        self._message(chat, message).delete()
        self.world.journal.add("deleted", chat_id=chat, message_id=message)

    def backlog(
        self, chat: int, user: int | None, text: str, count: int, **unusual: Unpack[MessageOptions]
    ) -> list[int]:
        """Write `count` messages at once; `{n}` in the text becomes 1, 2, 3 and so on."""
        return [
            self.say(chat, user, text.replace("{n}", str(n)), **unusual)
            for n in range(1, count + 1)
        ]

    def _post(
        self, chat: int, user: int | None, content: Content, unusual: MessageOptions
    ) -> Message:
        where = self.world.state.chats.get(chat)
        if where is None:
            raise ControlError(f"there is no chat {chat}")
        if where.migrated_to is not None:
            raise ControlError(f"chat {chat} became {where.migrated_to}")
        if user is not None:
            self._begin(where, user)
        received = replace(content, received_s=self.world.clock.now_s())
        author, sender_chat = self._author(where, user, unusual)
        message = self.world.keep(
            Message(
                chat_id=chat,
                message_id=self.world.new_message_id(where),
                date=self._date(unusual),
                versions=[received],
                from_id=author,
                sender_chat_id=sender_chat,
                reply_to=unusual.get("reply_to"),
                thread_id=unusual.get("thread"),
                extra=self._extra(unusual),
            )
        )
        if author is not None and self.world.state.users[author].is_bot and author == user:
            where.hear_bot(author)
        self.world.journal.add("said", chat_id=chat, message_id=message.message_id, edited=False)
        self.world.announce(message)
        if where.kind == "channel" and where.linked_chat_id is not None:
            self._forward_to_discussion(message, where)
        return message

    def _begin(self, where: ServerChat, user: int) -> None:
        self._require_present(where, user)
        person = self.world.state.users[user]
        if where.kind == "private":
            if person.blocked:
                raise ControlError("this person has blocked the bot; unblock it first")
            person.start()

    def _require_present(self, where: ServerChat, user: int) -> None:
        if user not in self.world.state.users:
            raise ControlError(f"there is no user {user}")
        there = where.id == user if where.kind == "private" else where.members.get(user) in PRESENT
        if not there and where.kind != "channel":
            raise ControlError(f"user {user} is not in chat {where.id}")

    def _author(
        self, where: ServerChat, user: int | None, unusual: MessageOptions
    ) -> tuple[int | None, int | None]:
        """Return `from` and `sender_chat` (https://core.telegram.org/bots/api#message)."""
        if where.kind == "channel":
            return None, where.id
        sender_chat = unusual.get("sender_chat")
        if sender_chat is None:
            return user, None
        return ANONYMOUS_ADMIN_ID if sender_chat == where.id else CHANNEL_BOT_ID, sender_chat

    def _forward_to_discussion(self, post: Message, channel: ServerChat) -> None:
        """Telegram's own account forwards a channel's post into the linked group."""
        group = self.world.state.chats[channel.linked_chat_id or 0]
        origin = {
            "type": "channel",
            "date": post.date,
            "chat": objects.chat(channel, self.world.state),
            "message_id": post.message_id,
        }
        forwarded = self.world.keep(
            Message(
                chat_id=group.id,
                message_id=self.world.new_message_id(group),
                date=post.date,
                versions=[post.content],
                from_id=SERVICE_ID,
                sender_chat_id=channel.id,
                extra={"is_automatic_forward": True, "forward_origin": origin},
            )
        )
        self.world.announce(forwarded)

    def _extra(self, unusual: MessageOptions) -> JsonObject:
        extra: JsonObject = dict(unusual.get("extra", {}))
        if (via_bot := unusual.get("via_bot")) is not None and via_bot is not False:
            bot = self.world.bot.id if via_bot is True else via_bot
            extra["via_bot"] = objects.user(self.world.state.users[bot])
        if (origin := unusual.get("forward_origin")) is not None:
            extra["forward_origin"] = self._origin(origin, self._date(unusual))
        return extra

    def _origin(self, origin: int | str | JsonObject, date: int) -> JsonObject:
        if isinstance(origin, dict):
            return origin
        if isinstance(origin, str):
            return {"type": "hidden_user", "date": date, "sender_user_name": origin}
        sender = objects.user(self.world.state.users[origin])
        return {"type": "user", "date": date, "sender_user": sender}

    def _date(self, unusual: MessageOptions) -> int:
        default = self.world.clock.date() - int(unusual.get("age_s", 0))
        return unusual.get("date", default)

    def _message(self, chat: int, message: int) -> Message:
        found = self.world.find(chat, message)
        if found is None:
            raise ControlError(f"there is no message {message} in chat {chat}")
        return found

    def _data_of(self, message: Message, button: str, *, stale: bool) -> str:
        versions = reversed(message.versions) if stale else [message.content]
        seen: list[str] = []
        for version in versions:
            for one in keyboards.buttons(version.reply_markup):
                if button in {one["text"], one.get("callback_data")} and "callback_data" in one:
                    return str(one["callback_data"])
                seen.append(one["text"])
        raise ControlError(f"there is no button {button!r} on this message; there are {seen}")
