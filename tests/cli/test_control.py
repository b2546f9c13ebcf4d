"""The control socket: who may use it, for what, and how little of it a stranger gets."""

from __future__ import annotations

import asyncio
import os
import socket
import stat
from typing import TYPE_CHECKING, cast

import pytest

from rosic.app.admin import control_client, control_socket
from rosic.app.admin.control_client import NotRunning, ask_gateway
from rosic.app.admin.control_socket import (
    ASK_BYTES,
    AT_ONCE,
    LONGEST_PATH_BYTES,
    READ_WITHIN_S,
    AdminRequest,
    AdminVerb,
    ControlServer,
    peer_uid,
    socket_path,
)
from rosic.errors import ConfigurationError, Fault, NotUnderstood
from rosic.stores.data_dir import DataDir
from rosic.stores.record_files import KeptFiles
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.app.admin.dispatch import AdminDispatcher


LONG_BYTES = 4 << 20  # far more than a socket holds for somebody who does not read


class AdminStandIn:
    """Stands where the operator's interface is: answers, and lets a test decide when."""

    def __init__(self) -> None:
        self.stopped: list[tuple[str, ...]] = []
        self.hold = asyncio.Event()
        self.hold.set()

    def status(self, names: tuple[str, ...]) -> tuple[str, ...]:
        if "kuka2" in names:
            raise NotUnderstood("There is no robot called kuka2.")
        if "long" in names:
            return ("x" * LONG_BYTES,)
        if "crash" in names:
            raise RuntimeError("a fault of ours")
        return ("omni: at rest", *names)

    async def stop(self, names: tuple[str, ...]) -> AsyncIterator[str]:
        self.stopped.append(names)
        yield "STOP sent to omni."
        yield "STOP: omni at rest (0.08 s)."

    async def do(self, ask: AdminRequest) -> tuple[str, ...]:
        await self.hold.wait()
        return (f"{' '.join(ask.names)} has no access any more, also after a restart.",)


@pytest.fixture
def desk() -> AdminStandIn:
    return AdminStandIn()


@pytest.fixture
async def server(tmp_path: Path, desk: AdminStandIn) -> AsyncIterator[ControlServer]:
    server = ControlServer(tmp_path, cast("AdminDispatcher", desk))
    await server.open()
    yield server
    await server.close()


async def answers(folder: Path, verb: AdminVerb, *names: str) -> list[tuple[str, bool]]:
    return [
        (one.text, one.good) async for one in ask_gateway(folder, AdminRequest(verb, names), print)
    ]


async def raw(folder: Path, sent: bytes) -> bytes:
    reader, writer = await asyncio.open_unix_connection(str(folder / "control.sock"))
    writer.write(sent)
    try:
        return await asyncio.wait_for(reader.read(), 60 * pace())
    except ConnectionResetError:
        return b""
    finally:
        writer.close()


@pytest.mark.usefixtures("server")
async def test_questions_are_answered_line_by_line(tmp_path: Path, desk: AdminStandIn) -> None:
    assert await answers(tmp_path, AdminVerb.STATUS, "omni") == [("omni: at rest\nomni", True)]
    assert await answers(tmp_path, AdminVerb.STOP) == [
        ("STOP sent to omni.", True),
        ("STOP: omni at rest (0.08 s).", True),
    ]
    assert desk.stopped == [()]
    assert await answers(tmp_path, AdminVerb.STATUS, "kuka2") == [
        ("There is no robot called kuka2.", False)
    ]
    [(sentence, good)] = await answers(tmp_path, AdminVerb.STATUS, "crash")
    assert not good
    assert "a fault of ours" not in sentence


@pytest.mark.usefixtures("server")
@pytest.mark.parametrize(
    "sent",
    [
        b"\n",
        b"{}\n",
        b"[]\n",
        b'{"verb":"fly"}\n',
        b'{"verb":"stop","more":1}\n',
        b"\xff\xfe\n",
        b'{"verb":"status","names":' + b"[" * 2000 + b"\n",
        b'{"verb":"status","names":["' + b"x" * (2 * ASK_BYTES) + b'"]}\n',
    ],
)
async def test_what_is_no_request_is_turned_away(
    tmp_path: Path, sent: bytes, desk: AdminStandIn
) -> None:
    answer = await raw(tmp_path, sent)

    assert b"no request" in answer
    assert desk.stopped == []
    assert (await answers(tmp_path, AdminVerb.STATUS))[0][1]


@pytest.mark.usefixtures("server")
async def test_a_stop_gets_through_when_everything_else_must_wait(
    tmp_path: Path, desk: AdminStandIn
) -> None:
    desk.hold.clear()
    waiting = [
        asyncio.create_task(answers(tmp_path, AdminVerb.REVOKE, "Bob")) for _ in range(AT_ONCE + 2)
    ]
    done, _ = await asyncio.wait(waiting, timeout=60 * pace(), return_when=asyncio.FIRST_COMPLETED)
    assert done
    assert next(iter(done)).result() == [("Too many commands at once. Try again.", False)]

    assert len(await answers(tmp_path, AdminVerb.STOP)) == 2
    desk.hold.set()
    await asyncio.gather(*waiting)


async def test_whoever_does_not_read_keeps_nobody_waiting(
    tmp_path: Path, desk: AdminStandIn
) -> None:
    server = ControlServer(tmp_path, cast("AdminDispatcher", desk), read_within_s=0.2)
    await server.open()
    deaf = [socket.socket(socket.AF_UNIX) for _ in range(AT_ONCE)]
    try:
        for connection in deaf:
            connection.connect(str(tmp_path / "control.sock"))
            connection.sendall(b'{"verb":"status","names":["long"]}\n')
        turned_away = [("Too many commands at once. Try again.", False)]
        async with asyncio.timeout(60 * pace()):
            while await answers(tmp_path, AdminVerb.STATUS) != turned_away:  # noqa: ASYNC110
                await asyncio.sleep(0)
            while await answers(tmp_path, AdminVerb.STATUS) == turned_away:  # noqa: ASYNC110
                await asyncio.sleep(0.02)
        # What they did not read is kept for nobody: they are hung up on, in the middle of it.
        assert await asyncio.to_thread(all_of, deaf[0]) < LONG_BYTES
    finally:
        for connection in deaf:
            connection.close()
        await server.close()


async def test_it_closes_without_waiting_for_who_does_not_read(
    tmp_path: Path, desk: AdminStandIn, caplog: pytest.LogCaptureFixture
) -> None:
    server = ControlServer(tmp_path, cast("AdminDispatcher", desk))
    await server.open()
    with socket.socket(socket.AF_UNIX) as deaf:
        deaf.connect(str(tmp_path / "control.sock"))
        deaf.sendall(b'{"verb":"status","names":["long"]}\n')
        assert await asyncio.to_thread(deaf.recv, 1)

        async with asyncio.timeout(READ_WITHIN_S - 1):
            await server.close()

        assert await asyncio.to_thread(all_of, deaf) < LONG_BYTES
    assert caplog.text == ""


def all_of(connection: socket.socket) -> int:
    """Return how many bytes there are to read, to the end."""
    connection.settimeout(60)
    count = 0
    while chunk := connection.recv(1 << 16):
        count += len(chunk)
    return count


async def test_only_its_owner_can_reach_it(tmp_path: Path, server: ControlServer) -> None:
    mode = (tmp_path / "control.sock").stat().st_mode
    assert stat.S_ISSOCK(mode)
    assert stat.S_IMODE(mode) == 0o600
    await server.close()
    assert not (tmp_path / "control.sock").exists()


def test_the_kernel_says_who_asks() -> None:
    ours, theirs = socket.socketpair(socket.AF_UNIX)
    with ours, theirs:
        assert peer_uid(ours) == os.getuid()


async def test_another_user_is_turned_away(tmp_path: Path, desk: AdminStandIn) -> None:
    ours = os.geteuid()
    # Only root can ask as somebody else; anybody else asks a gateway of somebody else.
    owner, stranger = (ours, 65534) if ours == 0 else (ours + 1, ours)
    server = ControlServer(tmp_path, cast("AdminDispatcher", desk), own_uid=owner)
    await server.open()
    # The folder and the socket let everybody in: what is left is to look at who they are.
    for path in (tmp_path / "control.sock", tmp_path):
        path.chmod(0o777)
    try:
        assert await asyncio.to_thread(ask_as, stranger, tmp_path / "control.sock") == b"connected:"
        assert desk.stopped == []
        if ours == 0:
            assert b"STOP" in await asyncio.to_thread(ask_as, 0, tmp_path / "control.sock")
    finally:
        await server.close()


def ask_as(uid: int, path: Path) -> bytes:
    """Ask for a stop as another user, in a process of its own; return the answer.

    It asks from within the folder: which of those above are open to that user is not asked about.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.chdir(path.parent)
            if uid != os.geteuid():
                os.setgroups([])
                os.setuid(uid)
            with socket.socket(socket.AF_UNIX) as connection:
                connection.settimeout(60)
                connection.connect(path.name)
                os.write(writing, b"connected:")
                connection.sendall(b'{"verb":"stop"}\n')
                while chunk := connection.recv(4096):
                    os.write(writing, chunk)
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as file:
        answer = file.read()
    os.waitpid(child, 0)
    return answer


async def test_where_nobody_listens_it_says_so(tmp_path: Path) -> None:
    with pytest.raises(NotRunning, match="No gateway is running"):
        await answers(tmp_path, AdminVerb.STATUS)
    with socket.socket(socket.AF_UNIX) as left_behind:
        left_behind.bind(str(tmp_path / "control.sock"))
    with pytest.raises(NotRunning, match="No gateway is running"):
        await answers(tmp_path, AdminVerb.STATUS)


async def test_a_socket_that_was_removed_or_replaced_is_made_anew(
    tmp_path: Path, desk: AdminStandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever asks meanwhile waits for it: the lock of the folder says that somebody is there."""
    monkeypatch.setattr(control_socket, "LOOK_EVERY_S", 0.05)
    folder, path = DataDir(tmp_path, KeptFiles(), begin_anew=False), tmp_path / "control.sock"
    folder.take()
    server = ControlServer(tmp_path, cast("AdminDispatcher", desk))
    await server.open()
    try:
        path.unlink()
        assert len(await answers(tmp_path, AdminVerb.STOP)) == 2
        (tmp_path / "gateway.lock").unlink()
        path.unlink()
        with socket.socket(socket.AF_UNIX) as other:
            other.bind(str(path))
        assert len(await answers(tmp_path, AdminVerb.STOP)) == 2
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    finally:
        await server.close()
        folder.give_back()
    assert not path.exists()
    with pytest.raises(NotRunning):
        await answers(tmp_path, AdminVerb.STATUS)


async def test_a_gateway_that_makes_no_socket_is_there_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(control_client, "SOCKET_WITHIN_S", 0.2)
    folder = DataDir(tmp_path, KeptFiles(), begin_anew=False)
    folder.take()
    try:
        with pytest.raises(Fault, match=rf"process {os.getpid()}\) has no control socket") as said:
            await answers(tmp_path, AdminVerb.STOP)
    finally:
        folder.give_back()
    assert not isinstance(said.value, NotRunning), "nobody else may change its data meanwhile"
    assert "the switch on the robot itself" in str(said.value)


async def test_a_gateway_that_hangs_is_told_of_soon_and_not_waited_for_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(control_client, "SLOW_AFTER_S", 0.05)
    monkeypatch.setattr(control_client, "HEARD_WITHIN_S", 0.2)
    told: list[str] = []
    with socket.socket(socket.AF_UNIX) as halted:
        halted.bind(str(tmp_path / "control.sock"))
        halted.listen()
        with pytest.raises(Fault, match=r"has not answered for 0\.2 s: it hangs"):
            _ = [
                one
                async for one in ask_gateway(tmp_path, AdminRequest(AdminVerb.STOP), told.append)
            ]
    assert len(told) == 1
    assert "use the switch on the robot itself" in told[0]


@pytest.mark.usefixtures("server")
async def test_an_answer_that_takes_long_is_waited_for(
    tmp_path: Path, desk: AdminStandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(control_client, "HEARD_WITHIN_S", 0.2)
    desk.hold.clear()
    asking = asyncio.create_task(answers(tmp_path, AdminVerb.REVOKE, "Bo"))
    await asyncio.wait((asking,), timeout=0.4)
    desk.hold.set()
    assert [good for _, good in await asking] == [True]


async def test_a_gateway_that_dies_while_asked_is_a_fault(tmp_path: Path) -> None:
    async def die(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.close()

    async with await asyncio.start_unix_server(die, str(tmp_path / "control.sock")):
        with pytest.raises(Fault):
            await answers(tmp_path, AdminVerb.STOP)


async def test_what_is_no_socket_is_left_where_it_is(tmp_path: Path, desk: AdminStandIn) -> None:
    (tmp_path / "control.sock").write_text("precious")

    with pytest.raises(ConfigurationError, match="in the way"):
        await ControlServer(tmp_path, cast("AdminDispatcher", desk)).open()

    assert (tmp_path / "control.sock").read_text() == "precious"


def test_a_path_too_long_for_a_socket_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=f"at most {LONGEST_PATH_BYTES}"):
        socket_path(tmp_path / ("é" * 60))
