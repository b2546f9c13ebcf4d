"""Personal content: unreadable in every file, readable in its place, gone once erased."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest
from nacl.bindings import crypto_aead_xchacha20poly1305_ietf_encrypt as encrypt

from rosic.core.records import Concluded, Enrolled, Letter, Placed
from rosic.errors import ConfigurationError
from rosic.stores.database import DatabaseStore
from rosic.stores.encryption import NONCE_BYTES, ROOM_BYTES, DecryptionError, RootKey, Sealer
from rosic.stores.record_mark import DATABASE
from rosic.stores.root_key import ROOT_KEY
from rosic.stores.stop_latch import FileLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import ADA, a_claim, a_conclusion, a_fact, an_enrolment, an_id, told

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.records import Fact, Record, Unfinished

BOB = "p-bob"


def a_store(folder: Path) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock())


def everything(folder: Path) -> bytes:
    return b"".join(path.read_bytes() for path in folder.iterdir())


def five_records(index: int, *said: bytes) -> tuple[Record, ...]:
    letters = [Letter(f"p{index % 20}", b"at " + text + b" there") for text in said]
    cid = an_id(index)
    return (
        a_claim(index, letter=letters[0]),
        Placed(cid=cid, letter=letters[1]),
        Concluded(cid=cid, ending="done", at_ns=1, letter=letters[2]),
        Enrolled(principal=f"e{index}", roles=(), at_ns=1, letter=letters[3]),
        a_fact(str(index), letter=letters[4]),
    )


async def unfinished(folder: Path) -> dict[bytes, Unfinished]:
    store = a_store(folder)
    open_orders = {open_order.cid: open_order for open_order in (await store.open()).unfinished}
    await store.close()
    return open_orders


async def facts(folder: Path) -> list[Fact]:
    store = a_store(folder)
    found = (await store.open()).facts
    await store.close()
    return [fact for kind in found.values() for fact in kind]


def change(folder: Path, *statements: str) -> None:
    with closing(sqlite3.connect(folder / DATABASE)) as database, database:
        for statement in statements:
            assert database.execute(statement).rowcount > 0, statement


async def test_a_thousand_secrets_are_in_no_file(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    secrets = [f"secret-{index:04d}-of-somebody".encode() for index in range(1250)]
    store, latch = a_store(folder), FileLatch(folder / "latch")
    await store.open()
    await asyncio.gather(
        *(
            store.write(*five_records(index, *secrets[index * 5 : index * 5 + 5]))
            for index in range(250)
        )
    )
    await latch.write("omni", 1, latched=True)
    names = {path.name for path in folder.iterdir()}
    assert names >= {DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm", "latch", ROOT_KEY}
    written = everything(folder)
    assert len(written) > 250_000
    assert not [secret for secret in secrets if secret in written]
    await store.close()
    await latch.close()
    written = everything(folder)
    assert not [secret for secret in secrets if secret in written]

    store = a_store(folder)
    memory = await store.open()
    await store.close()
    told = b"|".join(
        part or b""
        for open_order in memory.unfinished
        for part in (open_order.claim, open_order.placed, open_order.words)
    ) + b"|".join(record.letter.content for record in memory.enrolled)
    told += b"|".join(fact.letter.content for fact in memory.facts["slot"] if fact.letter)
    assert not [secret for secret in secrets if secret not in told]


SWAPS = {
    "another command": "UPDATE commands SET sealed = (SELECT sealed FROM commands WHERE seq = 2)"
    " WHERE seq = 1",
    "another kind": "UPDATE commands SET sealed = (SELECT sealed FROM endings WHERE seq = 1)"
    " WHERE seq = 1",
    "another container": "UPDATE commands SET container = 'p-bob' WHERE seq = 1",
    "two bytes": "UPDATE commands SET sealed = CAST(substr(sealed, 1, 40) || x'0000' ||"
    " substr(sealed, 43) AS BLOB) WHERE seq = 1",
    "another form": "UPDATE commands SET sealed = CAST(x'02' || substr(sealed, 2) AS BLOB)"
    " WHERE seq = 1",
}


@pytest.mark.parametrize("swap", SWAPS)
async def test_a_letter_is_readable_in_its_place_only(tmp_path: Path, swap: str) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim(1, letter=Letter(ADA, b"one")), a_conclusion(1))
    await store.write(a_claim(2, letter=Letter(ADA, b"two")))
    await store.write(a_claim(3, letter=Letter(BOB, b"three")))
    await store.close()
    assert (await unfinished(tmp_path))[an_id(1)].claim == b"one"
    change(tmp_path, SWAPS[swap])
    open_orders = await unfinished(tmp_path)
    assert open_orders[an_id(1)].claim is None
    assert (open_orders[an_id(2)].claim, open_orders[an_id(3)].claim) == (b"two", b"three")


FACT_SWAPS = {
    "another key": "UPDATE facts SET sealed = (SELECT sealed FROM facts WHERE key = 'c')"
    " WHERE id = 1",
    "another kind": "UPDATE facts SET sealed = (SELECT sealed FROM facts WHERE kind = 'grant')"
    " WHERE id = 1",
    "a kind that runs on into the key": "UPDATE facts SET kind = 'slota', key = 'b' WHERE id = 1",
    "another container": "UPDATE facts SET container = 'p-bob' WHERE id = 1",
}


@pytest.mark.parametrize("swap", FACT_SWAPS)
async def test_a_letter_of_a_fact_is_readable_in_its_place_only(tmp_path: Path, swap: str) -> None:
    store = a_store(tmp_path)
    await store.open()
    said = a_fact("ab", letter=Letter(ADA, b"one"))
    await store.write(said, a_fact("c", letter=Letter(ADA, b"two")))
    await store.write(a_fact("ab", kind="grant", letter=Letter(ADA, b"three")))
    await store.write(a_fact("d", letter=Letter(BOB, b"four")))
    await store.close()
    assert said in (await facts(tmp_path))
    change(tmp_path, FACT_SWAPS[swap])
    first, *others = await facts(tmp_path)
    assert (first.body, first.letter) == (b"so", None)
    assert [fact.letter and fact.letter.content for fact in others] == [b"two", b"four", b"three"]


async def test_erasing_a_container_erases_the_letters_of_its_facts(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(*(a_fact(key, letter=Letter(ADA, b"Ada")) for key in "12"))
    await store.write(a_fact("3", letter=Letter(BOB, b"Bob")), a_fact("2", b""), a_fact("4"))
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        sealed = dict(database.execute("SELECT key, sealed FROM facts").fetchall())
        keys = dict(database.execute("SELECT container, wrapped FROM containers").fetchall())
    assert sealed["1"] in everything(tmp_path)
    await store.shred(ADA)
    assert sealed["1"] not in everything(tmp_path)
    assert keys[ADA] not in everything(tmp_path)
    assert sealed["3"] in everything(tmp_path)
    await store.write(a_fact("5", letter=Letter(ADA, b"Ada again")))
    await store.close()
    assert await facts(tmp_path) == [
        a_fact("1"),
        a_fact("3", letter=Letter(BOB, b"Bob")),
        a_fact("4"),
        a_fact("5", letter=Letter(ADA, b"Ada again")),
    ]
    assert "could not be opened" not in caplog.text


async def test_a_letter_of_a_fact_whose_key_has_gone_is_left_out(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_fact("1", letter=Letter(ADA, b"Ada")))
    await store.close()
    change(tmp_path, "UPDATE containers SET wrapped = NULL WHERE container = 'p-ada'")
    assert await facts(tmp_path) == [a_fact("1")]


async def test_nobody_becomes_somebody_else_by_exchanging_cards(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    bob = Enrolled(principal=BOB, roles=("viewer",), at_ns=1, letter=Letter(ADA, b"Bob's card"))
    await store.write(an_enrolment(("admin",)), bob)
    await store.close()
    change(
        tmp_path,
        "UPDATE cards SET sealed = (SELECT sealed FROM cards WHERE principal = 'p-bob')"
        " WHERE principal = 'p-ada'",
    )
    store = a_store(tmp_path)
    assert (await store.open()).enrolled == (bob,)
    await store.close()


async def test_a_containers_key_works_for_that_container_only(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim(1), a_claim(2, letter=Letter(BOB, b"two")))
    await store.close()
    change(
        tmp_path,
        "UPDATE containers SET wrapped = (SELECT wrapped FROM containers WHERE container = 'p-bob')"
        " WHERE container = 'p-ada'",
    )
    open_orders = await unfinished(tmp_path)
    assert (open_orders[an_id(1)].claim, open_orders[an_id(2)].claim) == (None, b"two")


async def test_erasing_a_container_erases_its_key_everywhere(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.write(an_enrolment(), a_claim(1), a_claim(2, letter=Letter(BOB, b"two")))
    others = [a_claim(f"c{index}", letter=Letter(f"p{index}", b"")) for index in range(60)]
    await store.write(*others, *(told(f"c{index}") for index in range(60)))
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        keys = dict(database.execute("SELECT container, wrapped FROM containers").fetchall())
    assert keys[ADA] in everything(tmp_path)
    await store.shred(ADA)
    assert keys[ADA] not in everything(tmp_path)
    assert keys[BOB] in everything(tmp_path)
    # What is written afterwards has a new key; what was written before stays unreadable.
    await store.write(a_claim(3))
    await store.close()
    store = a_store(tmp_path)
    memory = await store.open()
    await store.close()
    assert memory.enrolled == ()
    assert [open_order.claim for open_order in memory.unfinished] == [None, b"two", b"chat 7"]


async def test_shredding_without_the_key_in_the_log_would_be_seen(tmp_path: Path) -> None:
    """The test above can fail: an ordinary update leaves the key behind."""
    store = a_store(tmp_path)
    await store.open()
    await store.write(a_claim(1))
    with closing(sqlite3.connect(tmp_path / DATABASE)) as database:
        (key,) = database.execute(
            "SELECT wrapped FROM containers WHERE container = ?", (ADA,)
        ).fetchone()
        with database:
            database.execute("UPDATE containers SET wrapped = NULL WHERE container = ?", (ADA,))
        assert key in everything(tmp_path)
    await store.close()


def test_a_key_opens_nothing_of_another_root() -> None:
    wrapped = RootKey(bytes(32)).new_key(ADA).wrapped
    with pytest.raises(DecryptionError):
        RootKey(bytes(range(32))).unwrap(ADA, wrapped)
    with pytest.raises(DecryptionError):
        RootKey(bytes(32)).unwrap(BOB, wrapped)
    with pytest.raises(DecryptionError):
        RootKey(bytes(32)).unwrap(ADA, wrapped[:40])


@pytest.mark.parametrize("size", [0, 1, 80, ROOM_BYTES, ROOM_BYTES + 1, 100_000])
def test_what_is_sealed_is_what_the_library_itself_would_seal(size: int) -> None:
    sealer, key, content = Sealer(), bytes(range(32)), b"w" * size
    for associated in (b"", b"ada"):
        sealed = sealer.seal(content, associated, key)
        nonce = sealed[1 : 1 + NONCE_BYTES]
        assert sealed == b"\x01" + nonce + encrypt(content, associated, nonce, key)


def test_no_nonce_is_used_twice() -> None:
    root = RootKey(bytes(32))
    keys = [root.new_key(ADA), root.new_key(BOB)]
    sealed = [key.seal(b"c", b"1", b"one") for _ in range(200) for key in keys]
    sealed += [key.wrapped for key in keys]
    assert len({letter[1 : 1 + NONCE_BYTES] for letter in sealed}) == len(sealed)


def test_nothing_is_sealed_with_half_a_key() -> None:
    with pytest.raises(ValueError, match="not a key"):
        Sealer().seal(b"one", b"", bytes(16))


async def test_the_sentence_about_the_root_key_names_no_key(tmp_path: Path) -> None:
    store = a_store(tmp_path)
    await store.open()
    await store.close()
    (tmp_path / ROOT_KEY).write_bytes(b"k" * 32)
    with pytest.raises(ConfigurationError) as caught:
        await a_store(tmp_path).open()
    assert "kkkk" not in str(caught.value)
