"""Updates as Telegram documents them, and as nobody has documented them, from a seed.

https://core.telegram.org/bots/api#update. The same seed gives the same updates. Beside each one
stands what it may do, worked out from its fields alone and from nothing of the adapter's.
"""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Any, NamedTuple

from rosic.testing.telegram.state import ANONYMOUS_ADMIN_ID, CHANNEL_BOT_ID, SERVICE_ID
from rosic.testing.telegram.updates import KINDS

if TYPE_CHECKING:
    from collections.abc import Callable
    from random import Random

Json = dict[str, Any]

OWN = "rosic_test_bot"
ADA, BO, VI, STRANGER, OTHER_BOT = 1001, 1002, 1003, 6666, 5550001
# One alone: a lease of another would stand in the way, and whoever often tries what they may not
# loses their key, and with it their stop.
MOVERS = frozenset({ADA})
FRESH_S = 4
MOVING = (
    "omni wave",
    "omni move 1 m",
    "/wave omni",
    f"/wave@{OWN} omni",
    f"@{OWN} omni wave",
    "o\x00mni wave",
)
STOPPING = ("stop", "/stop", "STOP", f"/stop@{OWN}", "stop omni", f"@{OWN} stop", "halt")
OTHERWISE = (
    "status",
    "help",
    "/start",
    "/start omni__wave",
    "robots",
    "use omni",
    "use nobody",
    "/me",
    "/people",
    "/mydata",
    "/invite operator",
    "/topic omni",
    "!omni wave",
    "?omni wave",
    "?",
    "resume",
    "\u202estop\u202c",
    "omni wave NaN m",
    "omni move 1e309 m",
    "\n" * 50,
    "omni wave@other_bot",
    "/wave@other_bot omni",
    "@other_bot omni wave",
    "leave it",
    "/code 000000",
    "\ud83d\udd90\ufe0f \U0001f916",
    "*omni wave*",
    "<b>omni wave</b>",
    "[omni wave](tg://user?id=1001)",
)
MEDIA = (
    "animation",
    "audio",
    "document",
    "paid_media",
    "photo",
    "sticker",
    "story",
    "video",
    "video_note",
    "voice",
    "checklist",
    "contact",
    "dice",
    "game",
    "poll",
    "venue",
    "location",
    "new_chat_members",
    "left_chat_member",
    "new_chat_title",
    "new_chat_photo",
    "delete_chat_photo",
    "group_chat_created",
    "message_auto_delete_timer_changed",
    "pinned_message",
    "invoice",
    "successful_payment",
    "refunded_payment",
    "users_shared",
    "chat_shared",
    "gift",
    "unique_gift",
    "connected_website",
    "write_access_allowed",
    "passport_data",
    "proximity_alert_triggered",
    "boost_added",
    "chat_background_set",
    "checklist_tasks_done",
    "forum_topic_created",
    "forum_topic_closed",
    "giveaway",
    "giveaway_winners",
    "video_chat_started",
    "web_app_data",
    "suggested_post_paid",
    "a_field_of_next_year",
)
TRIFLES = (
    "effect_id",
    "author_signature",
    "media_group_id",
    "has_protected_content",
    "paid_star_count",
    "show_caption_above_media",
    "has_media_spoiler",
    "sender_boost_count",
    "is_paid_post",
    "link_preview_options",
    "reply_to_checklist_task_id",
    "quote",
    "external_reply",
    "reply_to_story",
    "suggested_post_info",
    "direct_messages_topic",
    "a_trifle_of_next_year",
)
ODD: tuple[Any, ...] = (
    None,
    True,
    0,
    -1,
    2**63,
    1.5,
    "",
    "x",
    "stop omni",
    [],
    [[]],
    {},
    {"id": "x"},
    [None],
    "\x00",
)


class May(enum.Enum):
    """What one update may do to the robot that it names."""

    MUST_ACT = "a person's own, plain, fresh command: it is carried out once"
    MAY_ACT = "a fresh command of such a person, in company that may make it mean something else"
    MUST_STOP = "somebody known said stop, in whatever guise"
    NOTHING = "I17, or no command, or nobody who may"


class Generated(NamedTuple):
    """One update and what it may do. A stop may always stop."""

    raw: Json
    may: May


class Generator:
    """Makes updates.

    Args:
        chance: Seeded.
        now_s: The wall clock, which the updates are dated by.
    """

    def __init__(self, chance: Random, now_s: Callable[[], float]) -> None:
        self._chance = chance
        self._now_s = now_s
        self._number = 100
        self._messages = 0
        self._makers = {
            "callback_query": self._tap,
            "my_chat_member": self._member,
            "chat_member": self._member,
        }

    def update(self) -> Generated:
        """Return the next one."""
        chance = self._chance
        self._number += chance.choice((1, 1, 1, 2, 1000))
        kind = chance.choice(("message",) * 30 + (*KINDS, "edited_message", "channel_post", "new"))
        make = self._makers.get(kind)
        if make is None:
            said = chance.choice(chance.choice((MOVING, STOPPING, OTHERWISE)))
            content = self._message(said)
            may = _may(kind, content, said, self._now_s())
        else:
            content, may = make(), May.NOTHING
        raw = {"update_id": self._number, kind: content}
        if chance.random() < 0.04:
            # What it may do cannot be told any more; what it may not do, it may do even less.
            self._spoil(raw)
            may = May.MAY_ACT if may in {May.MUST_ACT, May.MAY_ACT} else May.NOTHING
        return Generated(raw, may)

    def _message(self, said: str) -> Json:
        chance = self._chance
        self._messages += 1
        message: Json = {
            "message_id": self._messages,
            "date": int(self._now_s()) - self._rarely(lambda: chance.choice(AGES), 0),
            "chat": self._chat(),
            "from": self._rarely(self._somebody, self._person(chance.choice((ADA, ADA, ADA, BO)))),
        }
        if message["chat"]["type"] == "private":
            message["chat"]["id"] = (message["from"] or {}).get("id", ADA)
        if message["chat"]["type"] == "channel":
            del message["from"]
            message["sender_chat"] = message["chat"]
        message["caption" if chance.random() < 0.1 else "text"] = said
        for add in (self._origin, self._media, self._company, self._trifles):
            self._rarely(lambda add=add: add(message), None)  # type: ignore[misc]
        return {name: value for name, value in message.items() if value is not None}

    def _rarely(self, make: Callable[[], Any], usual: Any) -> Any:  # noqa: ANN401
        return make() if self._chance.random() < 0.25 else usual

    def _person(self, number: int) -> Json:
        return {
            "id": number,
            "is_bot": False,
            "first_name": self._chance.choice(("Ada", OWN, "stop")),
            "username": "ada",
            "language_code": "de",
            "is_premium": True,
        }

    def _bot(self, number: int = OTHER_BOT) -> Json:
        return {"id": number, "is_bot": True, "first_name": "Bot", "username": "other_bot"}

    def _somebody(self) -> Json | None:
        people = (self._person(VI), self._person(STRANGER), None, self._person(SERVICE_ID))
        bots = (
            self._bot(),
            self._bot(ANONYMOUS_ADMIN_ID),
            self._bot(CHANNEL_BOT_ID),
            self._bot(ADA),
        )
        return self._chance.choice(people + bots)

    def _chat(self) -> Json:
        return dict(self._chance.choice(CHATS))

    def _origin(self, message: Json) -> None:
        """Make it something that was not written here and now by its sender's own hand."""
        kind, chance = self._chance.choice(ORIGINS), self._chance
        date = message["date"] - 5
        message |= {
            "user": _from("user", date, sender_user=self._person(BO)),
            "hidden": _from("hidden_user", date, sender_user_name="A"),
            "chat": _from("chat", date, sender_chat=self._chat()),
            "channel": _from("channel", date, chat=self._chat(), message_id=1),
            "future": {"forward_origin": {"type": "telepathy"}},
            "old": {"forward_date": date},
            "via": {"via_bot": self._bot()},
            "automatic": {"is_automatic_forward": True},
            "scheduled": {"is_from_offline": True},
            "in_the_name_of": {"sender_chat": self._chat()},
            "business": {"business_connection_id": "b", "sender_business_bot": self._bot()},
            "edited": {"edit_date": message["date"] + chance.choice((0, 1, 10_000))},
        }[kind]

    def _media(self, message: Json) -> None:
        for name in self._chance.sample(MEDIA, 3):
            message[name] = self._deep(3)
        if self._chance.random() < 0.1:
            for field in ("text", "caption"):
                if field in message:
                    message[field] += " " + "x\U0001f916" * 50_000

    def _company(self, message: Json) -> None:
        chance = self._chance
        reply: Json = {
            "message_id": 1,
            "date": 1,
            "chat": message["chat"],
            "from": self._somebody(),
        }
        for _ in range(chance.choice((0, 1, 30))):
            reply = {**reply, "message_id": 2, "reply_to_message": reply, "text": "omni wave"}
        message["reply_to_message"] = {k: v for k, v in reply.items() if v is not None}
        message |= chance.choice(
            (
                {},
                {"message_thread_id": 7, "is_topic_message": True},
                {"message_thread_id": 7},
            )
        )

    def _trifles(self, message: Json) -> None:
        for name in self._chance.sample(TRIFLES, 4):
            message[name] = self._deep(2)
        message["entities"] = [
            {
                "type": self._chance.choice(("bot_command", "mention", "unknown")),
                "offset": self._chance.choice((0, -1, 10**9)),
                "length": 5,
            }
        ]

    def _deep(self, left: int) -> Any:  # noqa: ANN401
        if not left or self._chance.random() < 0.3:
            return self._chance.choice(ODD)
        return {name: self._deep(left - 1) for name in self._chance.sample(MEDIA, 2)}

    def _tap(self) -> Json:
        """Return a tap on something that was never offered: bad clients send arbitrary data."""
        chance = self._chance
        query = {
            "id": str(self._number),
            "from": self._rarely(self._somebody, self._person(ADA)),
            "chat_instance": "1",
            "data": chance.choice((*MOVING, *OTHERWISE, "", "!omni wave")),
            "message": {"message_id": 1, "date": 0, "chat": self._chat()},
        }
        for gone in ("message", "data", "from"):
            if chance.random() < 0.1:
                del query[gone]
        query["inline_message_id"] = "x"
        return query

    def _member(self) -> Json:
        states = [
            {"user": self._bot(4242424242), "status": self._chance.choice(STATUSES)}
            for _ in range(2)
        ]
        chat, by = self._chat(), self._person(STRANGER)
        return {
            "chat": {**chat, "title": "omni wave"},
            "from": by,
            "date": int(self._now_s()),
            "old_chat_member": states[0],
            "new_chat_member": states[1],
        }

    def _spoil(self, value: Json) -> None:
        """Put something of another form somewhere."""
        name = self._chance.choice(list(value))
        if isinstance(value[name], dict) and value[name] and self._chance.random() < 0.8:
            self._spoil(value[name])
        else:
            value[name] = self._chance.choice(ODD)


AGES = (0, 0, 1, 6, 31, 86_400, 1_000_000, -30)
STATUSES = ("creator", "administrator", "member", "restricted", "left", "kicked", "new")
CHATS: tuple[Json, ...] = (
    {"id": ADA, "type": "private"},
    {"id": ADA, "type": "private"},
    {"id": -7, "type": "group"},
    {"id": -1009, "type": "supergroup", "is_forum": True},
    {"id": -1010, "type": "channel"},
    {"id": -8, "type": "congregation"},
)
ORIGINS = (
    "user",
    "hidden",
    "chat",
    "channel",
    "future",
    "old",
    "via",
    "automatic",
    "scheduled",
    "in_the_name_of",
    "business",
    "edited",
)
NOT_THEIR_OWN = frozenset(
    {
        "forward_origin",
        "forward_date",
        "via_bot",
        "is_automatic_forward",
        "is_from_offline",
        "sender_chat",
        "business_connection_id",
        "sender_business_bot",
        "edit_date",
    }
)
IN_COMPANY = frozenset(
    {
        "reply_to_message",
        "is_topic_message",
        "migrate_to_chat_id",
        *MEDIA,
    }
)
HEARD = frozenset({"message", "edited_message", "channel_post"})


def _from(kind: str, date: int, **more: object) -> Json:
    return {"forward_origin": {"type": kind, "date": date, **more}}


def _may(kind: str, message: Json, said: str, now_s: float) -> May:
    """Say what a message may do, by I17 and by who wrote it when."""
    sender = message.get("from", {})
    person = sender.get("id") in MOVERS and not sender.get("is_bot")
    if said in STOPPING:
        long = len(message.get("text", "")) > 100 or len(message.get("caption", "")) > 100
        sure = kind in HEARD and person and not IN_COMPANY & set(message) and not long
        return May.MUST_STOP if sure else May.NOTHING
    own = person and not NOT_THEIR_OWN & set(message)
    age_s = now_s - message["date"]
    if kind != "message" or said not in MOVING or not own or age_s > FRESH_S + 1:
        return May.NOTHING
    if message["chat"]["type"] == "channel":
        return May.NOTHING
    plain = age_s < FRESH_S and not IN_COMPANY & set(message)
    return May.MUST_ACT if plain else May.MAY_ACT
