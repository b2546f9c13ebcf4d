"""Where the root key comes from: a file, a credential of systemd, a passphrase."""

from __future__ import annotations

import errno
import os
import stat
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Fact, Letter
from rosic.errors import ConfigurationError
from rosic.stores.database import DatabaseStore
from rosic.stores.root_key import ROOT_KEY, SALT, create, read_key, root_of
from rosic.testing.clock import ManualClock
from tests.stores.waits import waits

if TYPE_CHECKING:
    from collections.abc import Iterator
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


@pytest.fixture
def nothing_stays_open() -> Iterator[None]:
    """See that a test leaves as many files open as it found."""
    before = sorted(os.listdir("/proc/self/fd"))  # noqa: PTH208 - a descriptor is no path
    yield
    assert sorted(os.listdir("/proc/self/fd")) == before  # noqa: PTH208


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
        assert [each.read_bytes() for each in tmp_path.iterdir()] == [b"k" * 32]

    create(path, b"k" * 32, wait_for_disk=confirm)
    draft = f"{ROOT_KEY}.new"
    assert seen == [(draft, {draft}), (tmp_path.name, {ROOT_KEY})]
    assert path.read_bytes() == b"k" * 32
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_key_waits_for_the_disk_itself(tmp_path: Path) -> None:
    with waits() as made:
        create(tmp_path / ROOT_KEY, b"k" * 32)
    assert made == ["fsync"] * 2, "the file, and the folder in which its name stands"


def test_a_key_that_the_disk_did_not_confirm_is_not_there(tmp_path: Path) -> None:
    def fail(descriptor: int) -> None:
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(5, "Input/output error")

    with pytest.raises(OSError, match="Input/output"):
        create(tmp_path / ROOT_KEY, b"k" * 32, wait_for_disk=fail)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("nothing_stays_open")
@pytest.mark.parametrize("name", [ROOT_KEY, SALT])
def test_a_secret_of_the_folder_is_not_looked_for_elsewhere(name: str, tmp_path: Path) -> None:
    """Whoever may put a link into the folder does not choose the key."""
    folder, words = tmp_path / "data", secret_file(tmp_path / "words", WORDS)
    folder.mkdir()
    create(tmp_path / "elsewhere", bytes(32 if name == ROOT_KEY else 16))
    (folder / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match=name) as caught:
        root_of(folder, {"ROSIC_PASSPHRASE_FILE": str(words)}, begun=True)
    assert caught.value.errno == errno.ELOOP


@pytest.mark.usefixtures("nothing_stays_open")
def test_a_link_is_followed_where_it_was_handed_over(tmp_path: Path) -> None:
    """As whatever hands credentials over may well give them."""
    folder, given = tmp_path / "data", tmp_path / "credentials"
    folder.mkdir()
    given.mkdir()
    create(tmp_path / "elsewhere", b"k" * 32)
    (given / "rosic.root-key").symlink_to(tmp_path / "elsewhere")
    found = root_of(folder, {"CREDENTIALS_DIRECTORY": str(given)}, begun=True)
    wrapped = found.new_key("one")
    create(folder / ROOT_KEY, b"k" * 32)
    root_of(folder, {}, begun=True).unwrap("one", wrapped.wrapped)


def test_a_credential_is_looked_for_in_no_folder_when_none_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The folder in which the gateway happens to be started is nobody's credential."""
    monkeypatch.chdir(tmp_path)
    create(tmp_path / "rosic.root-key", b"k" * 32)
    folder = tmp_path / "data"
    folder.mkdir()
    root_of(folder, {}, begun=False)
    assert (folder / ROOT_KEY).exists()


def test_a_credential_that_was_not_handed_over_after_all_is_none(tmp_path: Path) -> None:
    (tmp_path / "credentials").mkdir()
    (tmp_path / "data").mkdir()
    words = secret_file(tmp_path / "words", WORDS)
    environ = {
        "CREDENTIALS_DIRECTORY": str(tmp_path / "credentials"),
        "ROSIC_PASSPHRASE_FILE": str(words),
    }
    root_of(tmp_path / "data", environ, begun=False)
    assert (tmp_path / "data" / SALT).exists()


def test_a_passphrase_has_a_longest_length(tmp_path: Path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    environ = {"ROSIC_PASSPHRASE_FILE": str(tmp_path / "words")}
    secret_file(tmp_path / "words", b"w" * 1025)
    with pytest.raises(ConfigurationError, match="must have 12 to 1024 bytes"):
        root_of(folder, environ, begun=False)
    secret_file(tmp_path / "words", b"w" * 1024)
    root_of(folder, environ, begun=False)
    secret_file(tmp_path / "words", b"w" * 12 + b"\r\n")
    root_of(folder, environ, begun=True)


@pytest.mark.usefixtures("nothing_stays_open")
@pytest.mark.parametrize(
    ("size", "mode", "why"),
    [
        (31, 0o600, "damaged"),
        (33, 0o600, "damaged"),
        (32, 0o640, "can be read by others"),
        (32, 0o604, "can be read by others"),
        (32, 0o601, "can be read by others"),
    ],
)
def test_what_is_not_a_key_of_the_owner_alone_is_refused(
    size: int, mode: int, why: str, tmp_path: Path
) -> None:
    path = secret_file(tmp_path / ROOT_KEY, bytes(size))
    path.chmod(mode)
    with pytest.raises(ConfigurationError, match=why):
        read_key(path)


@pytest.mark.usefixtures("nothing_stays_open")
def test_a_passphrase_may_come_through_a_pipe_with_a_name(tmp_path: Path) -> None:
    """Nothing lies in it for others to read, whatever its mode."""
    (tmp_path / "data").mkdir()
    os.mkfifo(tmp_path / "pipe", 0o644)
    pipe = os.open(tmp_path / "pipe", os.O_RDWR)
    try:
        os.write(pipe, WORDS.encode())
        root_of(tmp_path / "data", {"ROSIC_PASSPHRASE_FILE": str(tmp_path / "pipe")}, begun=False)
    finally:
        os.close(pipe)
    assert (tmp_path / "data" / SALT).exists()


@pytest.mark.usefixtures("nothing_stays_open")
def test_what_a_start_that_was_cut_off_left_is_made_anew(tmp_path: Path) -> None:
    (tmp_path / f"{ROOT_KEY}.new").write_bytes(b"half")
    (tmp_path / f"{ROOT_KEY}.new").chmod(0o666)
    create(tmp_path / ROOT_KEY, b"k" * 32)
    assert [path.name for path in tmp_path.iterdir()] == [ROOT_KEY]
    assert read_key(tmp_path / ROOT_KEY) == b"k" * 32
