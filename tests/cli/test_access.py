"""Invitations, keys and locks from the command line, straight from the data."""

from __future__ import annotations

import asyncio
import json
import re
from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.dispatch import AdminApi
from rosic.app.admin.offline import OfflineAdmin, OfflineSeeding
from rosic.app.config import load_config
from rosic.cli.main import main
from rosic.errors import RecordUnavailable
from rosic.stores.memory import MemoryStore
from rosic.system import SystemClock, SystemEntropy
from tests.cli.offline import MEMORY, Place

if TYPE_CHECKING:
    from pathlib import Path

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")


@pytest.fixture
def place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Place:
    return Place(tmp_path, capsys).begun()


def on_disk(folder: Path) -> bytes:
    return b"".join(path.read_bytes() for path in folder.rglob("*") if path.is_file())


# ---- coming in ----


def test_an_invitation_is_shown_once_and_only_its_digest_is_kept(place: Place) -> None:
    out = place.good(
        "invite",
        "--role",
        "operator",
        "--robot",
        "kuka1",
        "--for",
        "2h",
        "--code-ttl",
        "20m",
        "--limit",
        "force <= 20 N",
        "--as",
        "Cy",
    )

    said, how, *picture = out.splitlines()
    [code] = set(CODE.findall(out))
    assert said.startswith(
        f"Invitation as operator on kuka1, with force <= 20 N, for 2 hours. Code {code}, good "
        "once, for 20 minutes"
    )
    assert how == f"Let them send the bot, in a private chat: join {code}"
    assert len(picture) > 10
    assert all(set(line) <= set("█▀▄ ") for line in picture)
    kept = on_disk(place.folder / "rosic-data")
    assert code.encode() not in kept
    assert code.replace("-", "").encode() not in kept
    assert "operator on kuka1, with force <= 20 N, for 2 hours" in place.good("security report")


def test_plain_is_without_a_picture(place: Place) -> None:
    out = place.good("invite", "--role", "viewer", "--plain")

    assert len(out.splitlines()) == 2
    assert "█" not in out


def test_an_admin_has_to_tap_where_that_was_said(place: Place) -> None:
    place.good("invite", "--role", "viewer", "--confirm", "--plain")
    report = json.loads(place.good("security report", "--json"))

    [invitation] = report["invitations"]
    assert invitation["given"] == "viewer"
    assert invitation["issuer"] == "operator"


def test_an_admin_invited_where_there_is_none_is_the_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = Place(tmp_path, capsys, MEMORY.replace('role = "admin"', 'role = "viewer"')).begun()

    first = place.good("invite", "--role", "admin", "--plain")
    second = place.good("invite", "--role", "admin", "--plain")

    assert "Nobody is admin here yet." in first
    assert CODE.findall(first) != CODE.findall(second)
    [only] = json.loads(place.good("security report", "--json"))["invitations"]
    assert only["given"] == "admin"  # the code of the first start ended with the second


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("", "An invitation needs a role, for example operator. Nothing was done."),
        ("--role operatr", "No role is called 'operatr'. Did you mean operator?"),
        (
            "--role operator --robot kuka9",
            "No robot or group is called 'kuka9'. Did you mean kuka1?",
        ),
        ("--role operator --robot cf*", "No robot matches 'cf*'. Known here: kuka1, omni."),
        (
            "--role operator --for soon",
            "as a length of time. Write --for 2h, --for 30min or --for 3d.",
        ),
        ("--role operator --for 2", "I cannot read --for '2' as a length of time."),
        ("--role operator --for 0m", "--for 0m is no time at all. Nothing was done."),
        ("--role operator --for -1h", "--for -1h is less than no time. Nothing was done."),
        ("--role operator --for 1y", "I cannot read --for '1y' as a length of time."),
        ("--role operator --for 9999d", "A right and a code last at least some seconds"),
        ("--role operator --code-ttl 365d", "a code at most a week. Nothing was done."),
        ("--role operator --code-ttl 0s", "--code-ttl 0s is no time at all."),
        ("--role operator --limit speed", "speed"),
        ("--role operator --limit height<=2m", "no parameter"),
        ("--role operator --robot kuka1 --limit force<=2kg", "force"),
    ],
)
def test_a_mistake_in_an_invitation_is_one_sentence(
    place: Place, arguments: str, sentence: str
) -> None:
    wrong = place.wrong("invite", *arguments.split())

    if sentence == "no parameter":
        assert "limits nothing" in wrong
    else:
        assert sentence in wrong
    assert "Open invitations: none." in place.good("security report")


def test_without_the_robots_of_a_file_an_invitation_to_one_says_so(
    place: Place, capsys: pytest.CaptureFixture[str]
) -> None:
    data = str(place.folder / "rosic-data")
    assert main(["invite", "--role", "viewer", "--robot", "omni", "--data", data]) == 2
    assert "a data folder alone does not say which robots" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["key list", "key revoke Bob", "revoke Bob", "container list"])
def test_what_asks_no_gateway_elsewhere_says_so_and_does_nothing_here(
    place: Place, command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    place.begun()
    place.good("key rotate", "Ada")
    monkeypatch.chdir(place.folder)
    monkeypatch.setenv("ROSIC_URL", "https://robots.example.org")
    assert main(command.split()) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert "ROSIC_URL names a gateway elsewhere, and this command asks none" in told.err
    assert "with -c rosic.toml or --data, or unset ROSIC_URL" in told.err
    assert "Bob: as operator" in place.good("people")
    assert main([*command.split(), "-c", str(place.config)]) == 0, capsys.readouterr().err


# ---- keys ----


def test_a_key_is_replaced_and_the_old_one_ends(place: Place) -> None:
    assert place.good("key rotate", "Bob", "--grace", "10m") == (
        "Bob has a new key. The old one is good for another 10 minutes.\n"
    )
    new, old = place.good("key list", "Bob").splitlines()
    assert new.endswith("  Bob  until taken back")
    assert old.endswith("  Bob  replaced by a newer key, good for another 10 minutes")
    found = json.loads(place.good("key list", "Bob", "--json"))
    assert [one["replaced"] for one in found] == [False, True]
    assert "Bob, key k" in place.good("security report")

    assert (
        place.good("key rotate", "Bob") == "Bob has a new key. The old one is not good any more.\n"
    )
    assert place.good("key list", "Bob").count("taken back\n") == 2
    assert "Bob: as operator" in place.good("people")
    assert len(place.good("key list").splitlines()) == 4


def test_a_key_is_taken_back_by_its_id_or_by_its_person(place: Place) -> None:
    place.good("key rotate", "Bob", "--grace", "10m")
    _, old = (line.split()[0] for line in place.good("key list", "Bob").splitlines())

    assert place.good("key revoke", old) == (
        f"The key {old} is not good any more, also after a restart.\n"
    )
    assert "Bob: as operator" in place.good("people")
    assert place.wrong("key revoke", old) == "This key was taken back before. Nothing was done."
    assert place.good("key revoke", "Bob") == (
        "Bob has no good key any more, also after a restart.\n"
    )
    assert "Bob: access ended" in place.good("people")
    assert "There is no good key to replace." in place.wrong("key rotate", "Bob")
    assert "There is no good key to replace." in place.wrong("key revoke", "Bob")


@pytest.mark.parametrize(
    "command", ["key list", "key rotate", "key revoke", "lock", "unlock", "revoke"]
)
def test_nobody_of_that_name_is_one_sentence(place: Place, command: str) -> None:
    assert place.wrong(command, "Zed") == "Nobody is called Zed. There are: Ada, Bob."


@pytest.mark.parametrize(
    ("grace", "sentence"),
    [
        ("-5m", "--grace -5m is less than no time."),
        ("later", "I cannot read --grace 'later'"),
        ("31d", "An old key stays good for at most 30 days. Nothing was done."),
    ],
)
def test_a_grace_that_is_none_is_one_sentence(place: Place, grace: str, sentence: str) -> None:
    assert sentence in place.wrong("key rotate", "Bob", "--grace", grace)


# ---- locks ----


def test_a_lock_holds_until_it_is_undone(place: Place) -> None:
    assert place.good("lock", "bob") == (
        "Bob is locked: nothing they send is carried out until an admin unlocks them.\n"
    )
    assert "Bob: locked · as operator" in place.good("people")
    assert "  Bob, by the operator, for" in place.good("security report")

    assert place.good("unlock", "Bob") == "Bob is unlocked.\n"
    assert "locked" not in place.good("people")
    assert place.wrong("unlock", "Bob") == "Bob is not locked. Nothing was done."


@pytest.mark.parametrize("by", ["revoke", "take_key", "take_key by its id"])
async def test_a_revocation_waits_for_no_other_change(place: Place, by: str) -> None:
    config = load_config(place.config)
    store = MemoryStore()
    memory = await store.open()
    alone = OfflineAdmin(place.folder, config, SystemClock(), SystemEntropy())
    books = await alone.books(store, memory, OfflineSeeding.WRITTEN)
    desk, [bob] = AdminApi(books), books.authoriser.directory.named("Bob")
    [key] = books.access.keys.of(bob.id)

    async with books.access.changes.turn():  # somebody else's write hangs on the disk
        does = desk.access.revoke if by == "revoke" else desk.access.take_key
        ending = asyncio.create_task(does(key.id if by.endswith("id") else "Bob"))
        await asyncio.sleep(0)
        assert not books.authoriser.has_access(bob.id)
        assert "also after a restart" in await ending, "it has a way of its own to the disk"
    await store.close()


async def test_a_lock_waits_for_no_other_change_and_for_no_disk(place: Place) -> None:
    config = load_config(place.config)
    store = MemoryStore()
    memory = await store.open()
    alone = OfflineAdmin(place.folder, config, SystemClock(), SystemEntropy())
    books = await alone.books(store, memory, OfflineSeeding.WRITTEN)
    desk, [bob] = AdminApi(books), books.authoriser.directory.named("Bob")

    async with books.access.changes.turn():  # somebody else's write hangs on the disk
        locking = asyncio.create_task(desk.access.lock("Bob"))
        await asyncio.sleep(0)
        assert bob.id in books.organiser.locked
        assert "until an admin unlocks" in await locking

    await store.close()
    with pytest.raises(RecordUnavailable):
        await desk.access.unlock("Bob")
    assert "it holds until ROSIC is restarted" in await desk.access.lock("Ada")
    assert len(books.organiser.locked) == 2


def test_revoking_ends_everything_of_somebody(place: Place) -> None:
    assert place.good("revoke", "Bob") == "Bob has no access any more, also after a restart.\n"
    assert "Bob: access ended" in place.good("people")
    assert place.good("revoke", "Bob") == "Bob has no access already. Nothing was changed.\n"


@pytest.mark.parametrize("command", ["revoke Ada", "key revoke Ada", "key revoke KEY"])
def test_the_last_admin_stays_until_there_is_another(place: Place, command: str) -> None:
    place.good("lock", "Bob")  # people of the file are on the record from here on
    key = place.good("key list", "Ada").split()[0]
    assert place.wrong(command.replace("KEY", key)) == (
        "Ada is the last admin here. Let another one in first: rosic invite --role admin. "
        "To keep Ada out at once: rosic lock Ada. Nothing was changed."
    )
    assert "Ada: as admin" in place.good("people")


def test_a_place_whose_only_admin_is_locked_gets_another_one(place: Place) -> None:
    place.good("lock", "Ada")
    assert "Nobody is admin here yet." in place.good("invite", "--role", "admin", "--plain")
    place.good("unlock", "Ada")
    assert "Invitation as admin." in place.good("invite", "--role", "admin", "--plain")


def test_looking_leaves_no_data_behind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = Place(tmp_path, capsys)
    place.good("people")
    place.good("key list")
    place.good("security report")
    place.good("explain", "Bob", "kuka1 home")

    assert not (place.folder / "rosic-data").exists()


@pytest.mark.parametrize(
    "command",
    [
        "people",
        "key list",
        "history",
        "explain Bob kuka1 home",
        "invite --role viewer --robot omni --plain",
        "lock Bob",
    ],
)
def test_nobody_needs_the_secret_of_a_messenger_to_look_after_people(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    bot = '\n[[messenger]]\nkind = "telegram"\ntoken = {{ env = "NOT_SET_IN_THIS_SHELL" }}\n'
    Place(tmp_path, capsys, MEMORY + bot).begun().good(command)


@pytest.mark.parametrize(
    "command",
    [
        "invite --role viewer",
        "lock Bob",
        "unlock Bob",
        "revoke Bob",
        "key revoke Bob",
        "key rotate Bob",
        "clock --accept",
        "container limit Bob --names 3",
    ],
)
def test_nothing_is_said_to_be_done_where_there_is_no_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """The folder may have been moved, or its disk be missing, while a gateway runs."""
    place = Place(tmp_path, capsys)
    said = place.rosic(command)
    assert (said.status, said.out) == (2, "")
    assert f"Nothing has run on {tmp_path}/rosic-data: there is no record." in said.err
    assert "Nothing was changed." in said.err
    assert not (tmp_path / "rosic-data").exists()
