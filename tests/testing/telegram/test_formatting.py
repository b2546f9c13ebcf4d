"""Entities and parse modes: https://core.telegram.org/bots/api#formatting-options."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.testing.telegram import ApiError
from rosic.testing.telegram.entities import cut, found, utf16_len
from rosic.testing.telegram.markup import parse

if TYPE_CHECKING:
    from rosic.testing.telegram import FakeTelegram
    from tests.testing.telegram.asking import Api


def marks(text: str, entities: list[dict[str, Any]]) -> list[tuple[str, str]]:
    return [(entity["type"], cut(text, entity["offset"], entity["length"])) for entity in entities]


@pytest.mark.parametrize(
    ("source", "text", "marked"),
    [
        ("<b>a</b> &lt;&#65;&#x42;", "a <AB", [("bold", "a")]),
        (
            "\U0001f916<i>x<u>y</u></i>",
            "\U0001f916xy",
            [("italic", "xy"), ("underline", "y")],
        ),
        ('<a href="https://x.org">x</a>', "x", [("text_link", "x")]),
        ('<span class="tg-spoiler">x</span>', "x", [("spoiler", "x")]),
        ('<pre><code class="language-python">x</code></pre>', "x", [("pre", "x")]),
        ("<blockquote expandable>x</blockquote>", "x", [("expandable_blockquote", "x")]),
        ("a & b &unknown;", "a & b &unknown;", []),
    ],
)
def test_html(source: str, text: str, marked: list[tuple[str, str]]) -> None:
    plain, entities = parse(source, "HTML")
    assert (plain, marks(plain, entities)) == (text, marked)


@pytest.mark.parametrize(
    "source",
    ["<b>x", "x</b>", "<b>x</i>", "<x>x</x>", "a < b", "<b><i>x</b></i>", "<span>x</span>", "<>"],
)
def test_html_that_is_not_well_formed(source: str) -> None:
    with pytest.raises(ApiError, match="can't parse entities"):
        parse(source, "HTML")


@pytest.mark.parametrize(
    ("source", "text", "marked"),
    [
        ("*a* _b_ __c__ ~d~ ||e||", "a b c d e", None),
        ("*a _b_*", "a b", [("bold", "a b"), ("italic", "b")]),
        ("`a*b`", "a*b", [("code", "a*b")]),
        ("```python\na.b\n```", "a.b\n", [("pre", "a.b\n")]),
        ("[x](https://x.org)", "x", [("text_link", "x")]),
        ("1\\.5 m\\!", "1.5 m!", []),
    ],
)
def test_markdown(source: str, text: str, marked: list[tuple[str, str]] | None) -> None:
    plain, entities = parse(source, "MarkdownV2")
    assert plain == text
    assert len(entities) == 5 if marked is None else marks(plain, entities) == marked


@pytest.mark.parametrize("source", ["1.5", "a-b", "*a", "`a", "[a](b", "[a] b", "a!", "_a*b_*"])
def test_markdown_that_is_not_well_formed(source: str) -> None:
    with pytest.raises(ApiError, match="can't parse entities"):
        parse(source, "MarkdownV2")


def test_the_sentence_about_reserved_characters_is_telegrams() -> None:
    with pytest.raises(ApiError) as refused:
        parse("1.5", "MarkdownV2")
    assert refused.value.description == (
        "Bad Request: can't parse entities: "
        "Character '.' is reserved and must be escaped with the preceding '\\'"
    )


@given(st.text(max_size=200), st.sampled_from(["HTML", "MarkdownV2"]))
def test_any_text_is_parsed_or_refused(text: str, mode: str) -> None:
    try:
        plain, entities = parse(text, mode)
    except ApiError:
        return
    assert all(e["offset"] + e["length"] <= utf16_len(plain) for e in entities)


def test_what_telegram_finds_by_itself() -> None:
    text = "\U0001f916 /stop@rosic_test_bot @ada https://x.org/a me@x.org #go x.org 1/2 a@b"
    assert marks(text, found(text)) == [
        ("bot_command", "/stop@rosic_test_bot"),
        ("mention", "@ada"),
        ("url", "https://x.org/a"),
        ("email", "me@x.org"),
        ("hashtag", "#go"),
        ("url", "x.org"),
    ]


async def test_the_bots_own_text_is_marked_too(server: FakeTelegram, api: Api, ada: int) -> None:
    """The record shows what Telegram made of a text that was meant to be inert."""
    await api.ok("sendMessage", chat_id=ada, text="see https://x.org")
    await api.ok(
        "sendMessage",
        chat_id=ada,
        text="see https://x.org",
        entities=[{"type": "code", "offset": 4, "length": 13}],
    )
    plain, inert = server.messages(ada)
    assert [entity["type"] for entity in plain["entities"]] == ["url"]
    assert [entity["type"] for entity in inert["entities"]] == ["code"]


@pytest.mark.parametrize(
    "entity",
    [
        {"type": "bold", "offset": 0, "length": 4},
        {"type": "bold", "offset": -1, "length": 1},
        {"type": "bold", "offset": 1, "length": 1},
        {"type": "bold", "offset": "0", "length": 1},
        {"type": "loud", "offset": 0, "length": 2},
        "bold",
    ],
)
async def test_entities_that_do_not_fit(api: Api, ada: int, entity: object) -> None:
    answer = await api.refusal("sendMessage", chat_id=ada, text="\U0001f916x", entities=[entity])
    assert answer.startswith("400 Bad Request: ")


async def test_trimming_moves_the_entities(server: FakeTelegram, api: Api, ada: int) -> None:
    bold = [{"type": "bold", "offset": 1, "length": 4}]
    await api.ok("sendMessage", chat_id=ada, text="  ab  ", entities=bold)
    assert server.messages(ada)[0]["entities"] == [{"type": "bold", "offset": 0, "length": 2}]
