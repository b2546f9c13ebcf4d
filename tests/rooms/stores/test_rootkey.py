"""Where the root key comes from: a file, a credential of systemd, a passphrase."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from rosic.core.record import Fact, Letter
from rosic.errors import ConfigurationError
from rosic.stores.database import DatabaseStore
from rosic.stores.rootkey import ROOT_KEY, SALT, create
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    from pathlib import Path

WORDS = "four robots in a row\n"
SECRET = b"a name nobody should read"


@pytest.fixture(autouse=True)
def nothing_given(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("CREDENTIALS_DIRECTORY", "ROSIC_PASSPHRASE_FILE"):
        monkeypatch.delenv(name, raising=False)


async def used(folder: Path) -> tuple[Fact, ...]:
    """Open a record, write something sealed the first time, and return what is there."""
    store = DatabaseStore(folder, clock=ManualClock())
    memory = await store.open()
    found = memory.facts.get("test", ())
    if not found:
        await store.write(Fact(kind="test", key="k", body=b"1", letter=Letter("p1", SECRET)))
    await store.close()
    return found


async def refused(folder: Path) -> ConfigurationError:
    store = DatabaseStore(folder, clock=ManualClock())
    with pytest.raises(ConfigurationError) as caught:
        await store.open()
    await store.close()
    return caught.value


def secret_file(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    path.chmod(0o600)
    return path


async def test_a_passphrase_opens_a_record_and_no_key_lies_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, file = tmp_path / "data", secret_file(tmp_path / "words", WORDS)
    monkeypatch.setenv("ROSIC_PASSPHRASE_FILE", str(file))
    assert await used(folder) == ()
    assert {path.name for path in folder.iterdir()} & {ROOT_KEY, SALT} == {SALT}
    (fact,) = await used(folder)
    assert fact.letter is not None
    assert fact.letter.content == SECRET

    file.write_text("four robots in a roe\n")
    assert "does not belong to this record" in str(await refused(folder))
    monkeypatch.delenv("ROSIC_PASSPHRASE_FILE")
    said = await refused(folder)
    assert "opens with a passphrase, and none was given" in str(said)
    assert "ROSIC_PASSPHRASE_FILE" in said.hint
    assert not (folder / ROOT_KEY).exists(), "no other key is made"


@pytest.mark.parametrize("name", ["rosic.root-key", "rosic.passphrase"])
async def test_a_systemd_credential_opens_a_record(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, given = tmp_path / "data", tmp_path / "credentials"
    given.mkdir()
    (given / name).write_bytes(bytes(range(32)))
    (given / name).chmod(0o440)  # systemd sees to who can read it
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(given))
    await used(folder)
    assert not (folder / ROOT_KEY).exists()
    assert len(await used(folder)) == 1
    (given / name).unlink()
    assert "passphrase" in str(await refused(folder)) or "is missing" in str(await refused(folder))


async def test_a_passphrase_that_others_can_read_or_that_is_short_makes_no_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, file = tmp_path / "data", secret_file(tmp_path / "words", WORDS)
    monkeypatch.setenv("ROSIC_PASSPHRASE_FILE", str(file))
    file.chmod(0o644)
    assert "can be read by others" in str(await refused(folder))
    secret_file(file, "short")
    assert "must have 12 to 1024 bytes" in str(await refused(folder))
    file.unlink()
    assert "words cannot be used" in str(await refused(folder))
    assert not (folder / ROOT_KEY).exists()
    assert not (folder / SALT).exists()


async def test_a_damaged_salt_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, file = tmp_path / "data", secret_file(tmp_path / "words", WORDS)
    monkeypatch.setenv("ROSIC_PASSPHRASE_FILE", str(file))
    await used(folder)
    (folder / SALT).write_bytes(b"half")
    assert "root.salt is damaged" in str(await refused(folder))


async def test_a_file_goes_on_opening_what_was_made_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "data"
    await used(folder)
    monkeypatch.setenv("ROSIC_PASSPHRASE_FILE", str(secret_file(tmp_path / "words", WORDS)))
    assert len(await used(folder)) == 1
    (folder / ROOT_KEY).unlink()
    assert "is missing" in str(await refused(folder)), "a passphrase is no way around it"


def test_a_key_is_on_disk_before_it_has_its_name_and_its_name_before_it_is_used(
    tmp_path: Path,
) -> None:
    """After a power cut a folder without its name in it is a folder without its key."""
    path = tmp_path / ROOT_KEY
    seen: list[tuple[str, set[str]]] = []

    def confirm(descriptor: int) -> None:
        inode = os.fstat(descriptor).st_ino
        (of,) = [
            each.name for each in (tmp_path, *tmp_path.iterdir()) if each.stat().st_ino == inode
        ]
        seen.append((of, {each.name for each in tmp_path.iterdir()}))

    create(path, b"k" * 32, wait_for_disk=confirm)
    draft = f"{ROOT_KEY}.new"
    assert seen == [(draft, {draft}), (tmp_path.name, {ROOT_KEY})]
    assert path.read_bytes() == b"k" * 32
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_key_that_the_disk_did_not_confirm_is_not_there(tmp_path: Path) -> None:
    def fail(_descriptor: int) -> None:
        raise OSError(5, "Input/output error")

    with pytest.raises(OSError, match="Input/output"):
        create(tmp_path / ROOT_KEY, b"k" * 32, wait_for_disk=fail)
    assert list(tmp_path.iterdir()) == []
