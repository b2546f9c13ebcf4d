"""What one person saw in one chat, in order, and what they did: from the record of the server.

A bot often changes a message instead of sending another. Each form under which somebody tapped is
kept as well as the last one, so that the conversation can be followed.
"""

from __future__ import annotations

from collections import defaultdict
from datetime import UTC, datetime, tzinfo
from typing import TYPE_CHECKING, Any

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.testing.telegram.state import JsonObject

START = "/start"
PHOTO, FILE = "(a picture)", "(a file)"


class Key(msgspec.Struct, frozen=True, omit_defaults=True):
    """A button under a message.

    Attributes:
        tap: Which of the person's taps was on it; 0: none.
    """

    label: str
    tap: int = 0


class Quote(msgspec.Struct, frozen=True):
    """What a message replies to: which one, whose, and what it says."""

    message: int
    name: str
    text: str


class Bubble(msgspec.Struct, frozen=True, omit_defaults=True, kw_only=True):
    """One form of one message.

    Attributes:
        name: Who wrote it, where several do; empty in a private chat.
        own: The person wrote it.
        at: What the clock showed.
        message: Number of the message; two forms of one share it.
        edited: It is not the first form.
        past: A later form took its place.
        answers: What it replies to.
        tap: It was written by a tap on Telegram's own START; which tap that was.
    """

    text: str
    at: str
    message: int
    name: str = ""
    own: bool = False
    keys: tuple[tuple[Key, ...], ...] = ()
    edited: bool = False
    past: bool = False
    answers: Quote | None = None
    tap: int = 0


class App(msgspec.Struct, frozen=True, omit_defaults=True):
    """Words of the messenger's own."""

    start: str = "START"
    edited: str = "edited"


ENGLISH = App()


class Transcript(msgspec.Struct, frozen=True, omit_defaults=True):
    """A conversation.

    Attributes:
        title: Of the chat.
        below: What stands under the title: the kind of chat, or who is in it.
        app: What the messenger itself says, in the person's language.
    """

    title: str
    bubbles: tuple[Bubble, ...]
    below: str = ""
    app: App = ENGLISH

    @property
    def taps(self) -> int:
        """How often the person tapped, START included."""
        keys = (key for bubble in self.bubbles for row in bubble.keys for key in row)
        return sum(1 for tap in (*(b.tap for b in self.bubbles), *(k.tap for k in keys)) if tap)

    @property
    def typed(self) -> int:
        """How many messages the person typed; START typed one for them."""
        return len({b.message for b in self.bubbles if b.own and not b.tap})

    @property
    def read(self) -> int:
        """How many messages there were to read, each form of one counted."""
        return sum(not bubble.own for bubble in self.bubbles)

    def lines(self) -> list[str]:
        """Return it as plain text, without times."""
        return [line for bubble in self.bubbles for line in _lines(bubble)]


def _lines(bubble: Bubble) -> Iterable[str]:
    if bubble.tap:
        yield "[START]*"
    first, *more = bubble.text.split("\n")
    yield f"{bubble.name or ('you' if bubble.own else 'bot')}> {first}"
    yield from (f"  {line}" for line in more)
    for row in bubble.keys:
        yield "  " + " ".join(f"[{key.label}]{'*' if key.tap else ''}" for key in row)


class TranscriptView(msgspec.Struct, frozen=True, kw_only=True):
    """Whose eyes, and what they are shown.

    Attributes:
        title: Of the chat.
        reader: Account whose messages are at the right, and whose taps are marked.
        below: What stands under the title.
        zone: Of the clock that is shown.
        every_form: Show each form of every message, not only those that were tapped.
        app: What the messenger itself says.
    """

    title: str
    reader: int
    below: str = ""
    zone: tzinfo = UTC
    every_form: bool = False
    app: App = ENGLISH


def transcript(
    messages: Sequence[JsonObject], presses: Sequence[JsonObject], view: TranscriptView
) -> Transcript:
    """Return a chat as one person saw it.

    Args:
        messages: As `ServerRecord.messages` returns them.
        presses: As `ServerRecord.presses` returns them; only the reader's count.
        view: Whose.
    """
    chat = _Chat([message for message in messages if _is_shown(message)], view)
    for press in presses:
        if press["user_id"] == view.reader:
            chat.tap(press)
    shown = [found for message in chat.messages for found in chat.forms(message)]
    shown.sort(key=lambda one: one[0])
    return Transcript(view.title, tuple(bubble for _, bubble in shown), view.below, view.app)


class _Chat:
    """The messages of a chat, and where they were tapped."""

    def __init__(self, messages: list[JsonObject], view: TranscriptView) -> None:
        self.messages = messages
        self._view = view
        self._by_id = {message["message_id"]: message for message in messages}
        self._several = len({m["from"] for m in messages if not m["by_bot"]}) > 1
        mine = (m["message_id"] for m in messages if m["from"] == view.reader and _is_start(m))
        self._start: int | None = next(mine, None)
        self._taps = 0 if self._start is None else 1
        self._tapped: defaultdict[tuple[int, int], dict[str, int]] = defaultdict(dict)

    def tap(self, press: JsonObject) -> None:
        """Count a tap, and note which form of which message it was on."""
        self._taps += 1
        message = self._by_id.get(press["message_id"])
        if message is not None:
            where = message["message_id"], _form_pressed(message, press)
            self._tapped[where][press["data"]] = self._taps

    def forms(self, message: JsonObject) -> Iterable[tuple[float, Bubble]]:
        """Return the forms of a message that are shown, each with when it came."""
        versions = message["versions"]
        for form, version in enumerate(versions):
            tapped = self._tapped.get((message["message_id"], form), {})
            last = form == len(versions) - 1
            if last or tapped or self._view.every_form:
                bubble = self._bubble(message, version, tapped)
                bubble = msgspec.structs.replace(bubble, edited=form > 0, past=not last)
                yield version["received_s"], bubble

    def _bubble(
        self, message: JsonObject, version: JsonObject, tapped: Mapping[str, int]
    ) -> Bubble:
        start = message["message_id"] == self._start
        return Bubble(
            text=START if start else _text(version),
            at=datetime.fromtimestamp(version["received_s"], self._view.zone).strftime("%H:%M"),
            message=message["message_id"],
            name=_name(message) if self._several else "",
            own=message["from"] == self._view.reader,
            keys=_keys(version, tapped),
            answers=self._answers(message),
            tap=1 if start else 0,
        )

    def _answers(self, message: JsonObject) -> Quote | None:
        replied = self._by_id.get(message["reply_to"] or 0)
        if replied is None:
            return None
        start = replied["message_id"] == self._start
        text = START if start else _text(replied)
        return Quote(replied["message_id"], _name(replied), text)


def _is_shown(message: JsonObject) -> bool:
    """Whether it is there, and something that somebody said: who came and went is not."""
    said = message["text"] or message["photo"] or message["document"]
    return bool(said) and not message["deleted"]


def _is_start(message: Mapping[str, Any]) -> bool:
    """Whether Telegram wrote it for somebody who tapped START; it hides what came with the link."""
    return str(message["text"]).partition(" ")[0] == START


def _form_pressed(message: JsonObject, press: JsonObject) -> int:
    """Return the newest form that had the button when it was pressed."""
    forms = [
        number
        for number, version in enumerate(message["versions"])
        if press["data"] in version["callback_data"] and version["received_s"] <= press["pressed_s"]
    ]
    return forms[-1] if forms else -1


def _text(version: JsonObject) -> str:
    if version["text"]:
        return str(version["text"])
    return PHOTO if version["photo"] else FILE


def _keys(version: JsonObject, tapped: Mapping[str, int]) -> tuple[tuple[Key, ...], ...]:
    return tuple(
        tuple(Key(key["text"], tapped.get(key.get("callback_data", ""), 0)) for key in row)
        for row in version["buttons"]
    )


def _name(message: JsonObject) -> str:
    return str(message["from_name"] or "")


def written(found: Transcript) -> bytes:
    """Return a transcript as JSON."""
    return msgspec.json.encode(found)


def read_transcript(content: bytes | str) -> Transcript:
    """Read what `written` returned."""
    return msgspec.json.decode(content, type=Transcript)
