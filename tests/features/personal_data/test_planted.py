"""Nothing that names a person or repeats their words stands in the open in any file."""

from __future__ import annotations

import logging
import random
import re
from base64 import b32decode, b32encode, b64encode
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

import msgspec

from rosic.app.logging import OneLine
from rosic.app.runtime import face_of
from rosic.authoriser import two_factor
from rosic.container import export
from rosic.container.files import PART
from rosic.core.identity import Address, AuthorisationKey
from rosic.core.message import ChatKind
from rosic.core.records import Enrolled, KeyIssued, Letter, PersonRecord
from rosic.features.personal_data import operator_view
from rosic.stores.record_mark import DATABASE
from rosic.testing.clock import ManualClock
from tests.features.personal_data.data_gateway import Ward, a_ward
from tests.gateway.place import ADA, BO

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

COUNT = 1_000
PEOPLE = 40
FORMS = (re.compile(rb"(?=(q[a-z]{13}))"), re.compile(rb"(?=((?:[67][0-9a-f]){14}))"))
LETTERS = "abcdefghijkmnopqrstuvwxyz"


def phrases() -> list[str]:
    chance = random.Random(7)  # noqa: S311 - a repeatable list, not a secret
    return ["q" + "".join(chance.choices(LETTERS, k=13)) for _ in range(COUNT)]


def found_in(folder: Path, planted: list[str]) -> dict[str, list[str]]:
    """Return which strings stand in which file: as they are, in UTF-16, and as hex."""
    wanted = {text.encode() for text in planted} | {t.encode().hex().encode() for t in planted}
    found: dict[str, list[str]] = {}
    for file in sorted(p for p in folder.rglob("*") if p.is_file()):
        content = file.read_bytes()
        for view in (content, content[::2], content[1::2]):
            seen = {hit for form in FORMS for hit in form.findall(view)} & wanted
            if seen:
                found[file.name] = sorted(hit.decode() for hit in seen)
    return found


def test_the_search_finds_what_is_there(tmp_path: Path) -> None:
    text = phrases()[0]
    for form in (
        text.encode(),
        b"xq" + text.encode() + b"q",
        text.encode("utf-16-le"),
        b"\0" + text.encode("utf-16-le"),
        text.encode().hex().encode(),
    ):
        (tmp_path / "file").write_bytes(form)
        assert list(found_in(tmp_path, phrases())) == ["file"]


async def enrolled(ward: Ward, name: str, account: str) -> None:
    who = f"p-{random.Random(name).randbytes(6).hex()}"  # noqa: S311 - an id
    card = Letter(who, msgspec.msgpack.encode(PersonRecord(name, (Address("memory", account),))))
    key = AuthorisationKey(id=f"k{who}", principal=who, issuer="operator", issued_ns=1)
    async with ward.gateway.access.changes.turn() as turn:
        await turn.write(
            (Enrolled(principal=who, roles=("operator",), at_ns=1, letter=card), KeyIssued(key=key))
        )


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@asynccontextmanager
async def logged(path: Path) -> AsyncIterator[None]:
    """Write everything that is logged into a file, down to what finds faults."""
    root, handler = logging.getLogger(), logging.FileHandler(path)
    handler.setFormatter(OneLine(face_of(), traces=True))
    before = root.level
    root.addHandler(handler)
    root.setLevel(logging.DEBUG)
    logging.getLogger("rosic.test").debug("begun")
    try:
        yield
    finally:
        root.setLevel(before)
        root.removeHandler(handler)
        handler.close()


async def a_phone(ward: Ward) -> bytes:
    """Let Bo set a phone up; return the secret in it."""
    said = await ward.said("authenticator", account=BO)
    secret = b32decode(pad(parse_qs(urlsplit(said.splitlines()[1]).query)["secret"][0]))
    code = two_factor.hotp(secret, two_factor.step_at(ward.clock.wall_ns()))
    ready = await ward.said("code", code, account=BO)
    assert ward.gateway.access.two_factor.is_set_up(ward.id_of(BO)), ready
    return secret


def pad(text: str) -> str:
    return text + "=" * (-len(text) % 8)


def secret_in(folder: Path, secret: bytes) -> list[str]:
    """Return which files hold a secret: as it is, in hex, and in the letters people type."""
    forms = (secret, secret.hex().encode(), b32encode(secret).rstrip(b"="), b64encode(secret)[:-2])
    files = (path for path in folder.rglob("*") if path.is_file())
    return [path.name for path in files if any(form in path.read_bytes() for form in forms)]


async def taken_out(ward: Ward) -> None:
    """Take everything out once: what is handed over leaves nothing behind on the disk."""
    for one in await operator_view.list_containers(ward.data_context):
        assert (
            sum(map(len, await operator_view.export_container(ward.data_context, one.container)))
            >= 0
        )
    for form in export.ENDINGS:
        reply = await ward.ask("archive", f"export {form}")
        assert reply.attachment is not None, reply.text
    assert (await ward.ask("mydata", "export")).attachment is not None


def ways(text: str, account: str, group: str) -> dict[int, tuple[str, str, ChatKind]]:
    """Return ways to say something, and where."""
    return {
        0: (text, group, ChatKind.GROUP),
        1: (f"omni {text}", account, ChatKind.PRIVATE),  # refused, with the word in the sentence
        2: (f"omni wave {text}", account, ChatKind.PRIVATE),
        4: (f"kuka1 wave\n{text}", group, ChatKind.GROUP),
        5: (text, ADA, ChatKind.PRIVATE),
    }


async def leave(ward: Ward, place: int, text: str, account: str) -> None:
    """Leave something in one's own container: data, what is shared of it, a file."""
    if place % 12 == 11:
        content = f"{text}\n".encode()
        ward.chat.enclose(f"{text}.txt", content, text=text, account=account, chat=account)
        return
    await ward.said("data", f"{text} = {text}", account=account)
    if place % 12 == 3:
        await ward.said("share", f"{text} with omni for 2h", account=account)


async def use(ward: Ward, planted: list[str]) -> None:
    """Use everything with planted strings: names, addresses, words, data, refusals, archives."""
    words = iter(planted)
    people = [(next(words), next(words)) for _ in range(PEOPLE)]
    group = next(words)
    for name, account in people:
        await enrolled(ward, name, account)
    for chat, kind in ((group, ChatKind.GROUP), (ADA, ChatKind.PRIVATE)):
        ward.chat.say("/archive on", account=ADA, chat=chat, kind=kind)
    await ward.quiet()
    await ward.say("omni wave", account=BO, chat=BO)
    for place, text in enumerate(words):
        account = people[place % PEOPLE][1]
        if place % 120 == 3:
            await ward.said("invite", f"viewer as {text}", account=ADA)
        elif place % 12 in {3, 9, 11}:
            await leave(ward, place, text, account)
        else:
            said, chat, kind = ways(text, account, group)[place % 6]
            ward.chat.say(said, account=account, chat=chat, kind=kind)
        if place % 40 == 0:
            await ward.quiet()  # what waits for the disk would be refused after a second
            await ward.clock.advance(1)
    await ward.quiet()
    ward.chat.say("stop", account=people[0][1], chat=people[0][1])
    await ward.clock.advance(5)


async def test_a_thousand_planted_strings_are_found_in_no_file(tmp_path: Path) -> None:
    planted, clock = phrases(), ManualClock()
    async with logged(tmp_path / "gateway.log"), a_ward(tmp_path, clock=clock) as ward:
        secret = await a_phone(ward)
        await use(ward, planted)
        await taken_out(ward)
        wal = tmp_path / f"{DATABASE}-wal"
        assert wal.stat().st_size > 0
        assert found_in(tmp_path, planted) == {}  # while it runs: the log file is full
        assert not secret_in(tmp_path, secret)
        assert {DATABASE, "latch", "root.key"} <= names_in(tmp_path)
        everything = [
            await ward.kept.container_facts(name) for name in await ward.kept.containers()
        ]
        parts = await ward.kept.facts(PART, "", COUNT)
        assert len(parts) > COUNT // 20
        everything.append(parts)
        said = msgspec.json.encode(
            [
                fact.letter.content.decode("latin-1")
                for held in everything
                for fact in held
                if fact.letter is not None
            ]
        ).decode()
        assert [text for text in planted if text not in said] == []  # all of them were kept
    assert found_in(tmp_path, planted) == {}
    assert (tmp_path / "gateway.log").stat().st_size > 0
    async with a_ward(tmp_path, clock=clock) as ward:
        await ward.quiet()
        assert ward.gateway.access.two_factor.is_set_up(ward.id_of(BO))
        assert not secret_in(tmp_path, secret)
        assert found_in(tmp_path, planted) == {}
