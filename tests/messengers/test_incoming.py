"""From Telegram's words to ours: who wrote, in which standing, and what is not for us."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from rosic.core.message import ChatKind, Inbound, MessageValidity
from rosic.messengers.telegram import incoming, updates
from rosic.messengers.telegram.incoming import ReceivedAt

DATE = 1_800_000_000
RECEIVED = ReceivedAt((DATE + 1) * 10**9 + 5, 17)
ADA: dict[str, Any] = {"id": 1001, "is_bot": False, "first_name": "Ada", "username": "bob"}
PRIVATE: dict[str, Any] = {"id": 1001, "type": "private", "first_name": "Ada"}
GROUP: dict[str, Any] = {"id": -1002, "type": "supergroup", "title": "Lab"}
CHANNEL: dict[str, Any] = {"id": -1003, "type": "channel", "title": "News"}
OTHER_BOT: dict[str, Any] = {"id": 55, "is_bot": True, "first_name": "Other"}


def read(kind: str = "message", **fields: Any) -> Inbound | None:  # noqa: ANN401
    message = {"message_id": 7, "date": DATE, "chat": PRIVATE, "from": ADA, "text": "status"}
    content = {key: value for key, value in (message | fields).items() if value is not None}
    update = updates.parse({"update_id": 1, kind: content})
    return incoming.read(update, "lab_robots_bot", RECEIVED)


def inbound(kind: str = "message", **fields: Any) -> Inbound:  # noqa: ANN401
    found = read(kind, **fields)
    assert found is not None
    return found


def test_a_plain_message() -> None:
    found = inbound()
    assert str(found.sender) == "telegram:1001"
    assert (found.chat.platform, found.chat.id, found.chat.kind) == (
        "telegram",
        "1001",
        ChatKind.PRIVATE,
    )
    assert (found.message, found.text, found.nonce, found.tap) == ("7", "status", None, "")
    assert (found.received_ns, found.listening_since_ns) == (RECEIVED.received_ns, 17)
    assert found.standing is MessageValidity.FRESH


def test_the_send_time_never_makes_it_younger_than_it_is() -> None:
    assert inbound().sent_ns == DATE * 10**9
    assert inbound(date=DATE + 60).sent_ns == RECEIVED.received_ns  # from the future
    edited = inbound("edited_message", edit_date=DATE + 1)
    assert edited.sent_ns == (DATE + 1) * 10**9


@pytest.mark.parametrize(
    ("fields", "standing"),
    [
        ({"forward_origin": {"type": "user", "date": DATE, "sender_user": ADA}}, "forwarded"),
        ({"forward_origin": {"type": "hidden_user", "sender_user_name": "A"}}, "forwarded"),
        ({"forward_date": DATE}, "forwarded"),
        ({"via_bot": OTHER_BOT}, "via-bot"),
        ({"edit_date": DATE}, "edited"),
        ({"is_from_offline": True}, "via-bot"),
        ({"sender_business_bot": OTHER_BOT}, "via-bot"),
        ({"business_connection_id": "x"}, "via-bot"),
        ({"from": OTHER_BOT, "chat": GROUP}, "via-bot"),
        (
            {"from": {"id": 1087968824, "is_bot": True}, "sender_chat": GROUP, "chat": GROUP},
            "anonymous",
        ),
        ({"from": {"id": 1087968824, "is_bot": True}, "chat": GROUP}, "anonymous"),
        ({"sender_chat": GROUP, "chat": GROUP}, "anonymous"),
        ({"from": None, "chat": GROUP}, "anonymous"),
        ({"from": {"id": 777000}, "sender_chat": CHANNEL, "chat": GROUP}, "channel"),
        ({"from": {"id": 777000}, "chat": PRIVATE}, "channel"),
        ({"from": {"id": 136817688}, "sender_chat": CHANNEL, "chat": GROUP}, "channel"),
        ({"is_automatic_forward": True, "chat": GROUP}, "channel"),
    ],
)
def test_what_changes_nothing(fields: dict[str, Any], standing: str) -> None:
    assert inbound(**fields).standing is MessageValidity(standing)


def test_edited_and_posted_messages_change_nothing_either() -> None:
    assert inbound("edited_message").standing is MessageValidity.EDITED
    posted = inbound("channel_post", chat=CHANNEL, **{"from": None})
    assert posted.standing is MessageValidity.CHANNEL
    assert posted.chat.kind is ChatKind.CHANNEL
    assert posted.sender.account == "-1003"
    changed = inbound("edited_channel_post", chat=CHANNEL, edit_date=DATE + 1, **{"from": None})
    assert changed.standing is MessageValidity.CHANNEL
    assert changed.chat == posted.chat


@pytest.mark.parametrize("marks", ["entities", "caption_entities"])
def test_links_are_read_that_stand_behind_words(marks: str) -> None:
    link = {
        "type": "text_link",
        "offset": 0,
        "length": 2,
        "url": "https://t.me/lab?start=7K3M-Q0ZD",
    }
    malformed: tuple[Any, ...] = ({"type": "bold"}, 7, {"url": 7}, None)
    read = inbound("message", **{marks: [*malformed, link, link]})
    assert read.links == ("https://t.me/lab?start=7K3M-Q0ZD",)
    assert inbound("message", **{marks: "malformed"}).links == ()


def test_what_is_taken_out_of_a_text_is_there_as_it_was_written() -> None:
    assert inbound(text="@lab_robots_bot hi").written == "@lab_robots_bot hi"
    assert inbound(text="hi\n@other_bot yes").written == "hi\n@other_bot yes"
    assert inbound(text="hi").written == ""


def test_a_quotation_is_no_part_of_what_was_written() -> None:
    assert inbound(quote={"text": "stop", "position": 0}).text == "status"


OWN: dict[str, Any] = {"id": 4, "is_bot": True, "username": "Lab_robots_bot"}


@pytest.mark.parametrize(
    ("author", "ours"),
    [
        (OWN, True),
        (OWN | {"id": 77, "username": None}, True),  # by its number alone
        ({"id": updates.TELEGRAM, "is_bot": False}, True),  # brought from a channel, perhaps ours
        (ADA, False),
        ({"id": updates.GROUP_ANONYMOUS_BOT, "is_bot": True, "username": "GroupBot"}, False),
        (ADA | {"username": "lab_robots_bot"}, False),
        (None, False),
        (7, False),
    ],
)
def test_whether_it_replies_to_a_message_of_ours(author: object, ours: bool) -> None:
    received = RECEIVED._replace(account="77")
    message = {"message_id": 7, "date": DATE, "chat": GROUP, "from": ADA, "text": "move 1 m"}
    here = {"reply_to_message": {"message_id": 3, "chat": GROUP, "from": author}}
    elsewhere = {"external_reply": {"origin": {"type": "user", "sender_user": author}}}
    for reply, answers in ((here, "3"), (elsewhere, "")):
        update = updates.parse({"update_id": 1, "message": message | reply})
        found = incoming.read(update, "lab_robots_bot", received)
        assert found is not None
        assert (found.answers, found.answers_us) == (answers, ours)
    assert not inbound(external_reply="malformed").answers_us


def test_a_caption_counts_as_text_and_nothing_as_nothing() -> None:
    assert inbound(text=None, caption="stop", photo=[]).text == "stop"
    assert read(text=None, sticker={"emoji": "🛑"}) is None
    assert read(text=None, new_chat_members=[ADA]) is None
    assert incoming.read(updates.Update(update_id=1), "x", RECEIVED) is None


@pytest.mark.parametrize(
    ("text", "heard"),
    [
        ("/stop@lab_robots_bot", "/stop"),
        ("/stop@LAB_Robots_Bot omni", "/stop omni"),
        ("/move@lab_robots_bot omni 1 m", "/move omni 1 m"),
        ("/move@other_bot omni 1 m", None),
        ("/stop@other_bot", "/stop"),  # whomever it names: a hurried tap in the menu picks either
        ("/stop@other_bot omni", "/stop omni"),
        ("@lab_robots_bot stop", "stop"),
        ("@lab_robots_bot, status", "status"),
        ("@other_bot status", None),
        ("@other_bot status\nstatus", "\nstatus"),
        ("@other_bot stop", "@other_bot stop"),
        ("@bob status", "@bob status"),
        ("/use@other_bot omni\nstatus", "\nstatus"),
        ("/use@other_bot omni\n/use@third_bot omni", None),
        ("tell @lab_robots_bot", "tell @lab_robots_bot"),
        ("/move@lab_robots_botx omni", None),
    ],
)
def test_whom_it_is_addressed_to(text: str, heard: str | None) -> None:
    found = read(text=text, chat=GROUP)
    assert (found.text if found else None) == heard


def tap(**fields: Any) -> Inbound | None:  # noqa: ANN401
    query = {
        "id": "4382bfdwdsb323b2d9",
        "from": ADA,
        "message": {"message_id": 9, "date": 0, "chat": GROUP},
        "chat_instance": "1",
        "data": "nonce-1",
    } | fields
    update = updates.parse({"update_id": 1, "callback_query": query})
    return incoming.read(update, "lab_robots_bot", RECEIVED)


def test_a_tap_is_the_tappers_and_has_no_time_of_its_own() -> None:
    found = tap()
    assert found is not None
    assert (str(found.sender), found.chat.id) == ("telegram:1001", "-1002")
    assert (found.nonce, found.text, found.under) == ("nonce-1", "", "9")
    assert found.message == found.tap == "4382bfdwdsb323b2d9"
    assert found.sent_ns == found.received_ns == RECEIVED.received_ns


def test_a_tap_that_is_not_on_a_message_of_ours_is_passed_over() -> None:
    assert tap(message=None, inline_message_id="x") is None
    assert tap(data=None, game_short_name="chess") is None


def test_a_group_that_moves() -> None:
    def moved(**fields: Any) -> tuple[str, str] | None:  # noqa: ANN401
        message = {"message_id": 1, "date": DATE, "chat": GROUP, "from": ADA} | fields
        return incoming.moved(updates.parse({"update_id": 1, "message": message}))

    assert moved(migrate_to_chat_id=-100500) == ("-1002", "-100500")
    assert moved(migrate_from_chat_id=-7) == ("-7", "-1002")
    assert moved() is None


@pytest.mark.parametrize(
    "raw",
    [
        {"update_id": 1, "message": "hello"},
        {"update_id": 1, "message": {"text": "hello"}},
        {"update_id": 1, "message": {"message_id": 1, "date": "now", "chat": PRIVATE}},
        {"update_id": 1, "callback_query": {"id": 5}},
        {"update_id": 1, "message": {"message_id": 1, "date": 1, "chat": PRIVATE, "text": 5}},
    ],
)
def test_what_is_malformed_says_so(raw: object) -> None:
    for given in (raw, msgspec.Raw(msgspec.json.encode(raw))):
        assert updates.update_id(given) == 1
        with pytest.raises(msgspec.ValidationError):
            updates.parse(given)


@pytest.mark.parametrize(
    ("said", "number", "text"),
    [
        (
            b' { "update_id" : 7, "message":{"message_id":1,"date":1,"chat":{"id":1},"text":"a"}}',
            7,
            "a",
        ),
        (b'{"message":{"message_id":1,"date":1,"chat":{"id":1},"text":"b"},"update_id":8}', 8, "b"),
        (
            b'{"message":{"message_id":1,"date":1,"chat":{"id":1},"text":"\\ud800stop"},"update_id":9}',
            9,
            "\ud800stop",
        ),
    ],
)
def test_an_update_is_read_as_it_came_over_the_wire(said: bytes, number: int, text: str) -> None:
    raw = msgspec.Raw(said)
    assert updates.update_id(raw) == number
    update = updates.parse(raw)
    assert update.message is not None
    assert update.message.text == text


def test_what_is_new_to_us_is_passed_over() -> None:
    unknown = {"update_id": 1, "message_from_the_future": {"x": [1, 2]}}
    assert incoming.read(updates.parse(unknown), "x", RECEIVED) is None
    assert updates.update_id([]) is None
    assert updates.update_id(msgspec.Raw(b"[1]")) is None
    assert updates.update_id(msgspec.Raw(b'{"update_id":"1"}')) is None
    assert updates.update_id({"update_id": "1"}) is None
