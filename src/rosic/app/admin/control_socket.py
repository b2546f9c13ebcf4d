"""The control socket, on which a running gateway answers ``rosic`` commands of the same machine.

Unix, 0600, in the data folder; one JSON object a line, both ways; only the same user or root.
"""

from __future__ import annotations

import asyncio
import logging
import os
import socket
import stat
import struct
from contextlib import suppress
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.core.i18n import plain
from rosic.errors import ConfigurationError, RosicError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.app.admin.dispatch import AdminDispatcher

__all__ = (
    "ANSWER_BYTES",
    "ASK_BYTES",
    "AT_ONCE",
    "LONGEST_PATH_BYTES",
    "AdminAnswer",
    "AdminRequest",
    "AdminVerb",
    "ControlServer",
    "peer_uid",
    "socket_path",
)

SOCKET = "control.sock"
LONGEST_PATH_BYTES = 107
ASK_BYTES = 262_144  # a plan of 2,000 slots
ANSWER_BYTES = 1_048_576
CONNECTIONS_AT_MOST = 256
AT_ONCE = 16  # a stop is not counted
ASK_WITHIN_S = 5.0
READ_WITHIN_S = 5.0
LOOK_EVERY_S = 2.0

log = logging.getLogger("rosic.control")


class AdminAnswer(msgspec.Struct, frozen=True):
    """One of the answers to a request, each a line.

    Attributes:
        good: False when the request was refused or failed.
        more: Another answer follows.
    """

    text: str
    good: bool = True
    more: bool = False


HEARD = AdminAnswer("", more=True)
LASTING = frozenset({AdminVerb.ATTACH, AdminVerb.RECORD})
"""What keeps the connection, and is answered in its own way."""

_decode_ask = msgspec.json.Decoder(AdminRequest).decode
encode = msgspec.json.Encoder(enc_hook=plain).encode


def socket_path(data: Path) -> Path:
    """Return where the socket of a data folder is.

    Raises:
        ConfigurationError: The path is longer than a Unix socket's may be.
    """
    path = data / SOCKET
    length = len(os.fsencode(path))
    if length > LONGEST_PATH_BYTES:
        raise ConfigurationError(
            f"The path of the data folder is too long: its control socket would have {length} "
            f"bytes, and at most {LONGEST_PATH_BYTES} are possible.",
            hint="Name a data folder with a shorter path.",
        )
    return path


class ControlServer:
    """Answers on the socket of a gateway that has taken the data folder.

    Args:
        own_uid: Whose requests are answered besides root's; None takes this process's user.
        read_within_s: Whoever has not read an answer by then is hung up on.
    """

    def __init__(
        self,
        data: Path,
        operating: AdminDispatcher,
        *,
        own_uid: int | None = None,
        read_within_s: float = READ_WITHIN_S,
    ) -> None:
        self._path = socket_path(data)
        self._operating = operating
        self._own_uid = os.geteuid() if own_uid is None else own_uid
        self._read_within_s = read_within_s
        self._server: asyncio.Server | None = None
        self._answering: set[asyncio.Task[None]] = set()
        self._following = 0
        self._number = (0, 0)
        self._looking: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Listen. What a gateway that died left behind is removed: the folder is ours now.

        A socket that somebody removes or replaces meanwhile is made anew.

        Raises:
            ConfigurationError: Something that is no socket stands in the way, or the folder
                cannot be written.
        """
        await self._listen()
        self._looking = asyncio.create_task(self._look())

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(LOOK_EVERY_S)
            if not self._is_there():
                log.warning("the control socket %s was removed: it is made anew", self._path)
                before = self._server
                try:
                    await self._listen()
                except ConfigurationError as error:
                    log.warning("%s", error)
                else:
                    if before is not None:
                        before.close()

    def _is_there(self) -> bool:
        try:
            return _number(self._path) == self._number
        except OSError:
            return False

    async def _listen(self) -> None:
        try:
            self._clear()
            listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                # Closed to others before anybody can connect: nobody can until it listens.
                listener.bind(str(self._path))
                self._path.chmod(0o600)
                self._server = await asyncio.start_unix_server(
                    self._connected, sock=listener, limit=ASK_BYTES
                )
                self._number = _number(self._path)
            except BaseException:
                listener.close()
                raise
        except OSError as error:
            raise ConfigurationError(
                f"The control socket {self._path} cannot be made ({error.strerror}).",
                hint="The data folder must be on a local disk that can hold sockets.",
            ) from error

    def _clear(self) -> None:
        with suppress(FileNotFoundError):
            if not stat.S_ISSOCK(self._path.lstat().st_mode):
                raise ConfigurationError(
                    f"{self._path} is in the way: the control socket belongs there.",
                    hint="Move it elsewhere.",
                )
            self._path.unlink()

    async def close(self) -> None:
        """Answer nobody any more, and take the socket away."""
        if self._looking is not None:
            self._looking.cancel()
            await asyncio.wait((self._looking,))
        if self._server is None:
            return
        self._server.close()
        self._server = None
        with suppress(OSError):
            self._path.unlink()
        for task in self._answering:
            task.cancel()
        await asyncio.gather(*self._answering, return_exceptions=True)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        if task is not None:
            self._answering.add(task)
        writer.transport.set_write_buffer_limits(0)  # drained is what has left this process
        try:
            uid = peer_uid(writer.get_extra_info("socket"))
            if uid not in (self._own_uid, 0):
                log.warning("user %d was turned away from the control socket", uid)
            elif len(self._answering) <= CONNECTIONS_AT_MOST:
                await self._answer(reader, writer)
            await self._read(writer)
        except (OSError, TimeoutError):
            # Whoever asked has gone, or does not read: closing would wait for them.
            writer.transport.abort()
        except asyncio.CancelledError:
            writer.transport.abort()
            if self._server is not None:
                raise  # else it was `close`, and asyncio would log this as an error
        finally:
            writer.close()
            if task is not None:
                self._answering.discard(task)

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            ask = _decode_ask(await asyncio.wait_for(_first_line(reader), ASK_WITHIN_S))
        except (ValueError, msgspec.MsgspecError, EOFError):
            writer.write(_line(AdminAnswer("That is no request I know.", good=False)))
            return
        if ask.verb in LASTING:
            await self._attach(ask, reader, writer)
            return
        if ask.verb is not AdminVerb.STOP and self._following >= AT_ONCE:
            writer.write(_line(AdminAnswer("Too many commands at once. Try again.", good=False)))
            return
        self._following += 1
        try:
            writer.write(_line(HEARD))
            async for text in self._follow(ask):
                writer.write(
                    _line(AdminAnswer(str(text), more=True))
                )  # a sentence as it is in English
                await self._read(writer)
            writer.write(_line(AdminAnswer("")))
        except RosicError as error:
            writer.write(_line(AdminAnswer(str(error), good=False)))
        except OSError:
            raise
        except Exception:
            log.exception("a control request failed")
            writer.write(_line(AdminAnswer("Something went wrong; the log says what.", good=False)))
        finally:
            self._following -= 1

    async def _attach(
        self, ask: AdminRequest, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        """Leave a connection to what lasts: a program, once it has shown who it is; a recording."""
        try:
            serve = self._operating.attach(ask)
        except RosicError as error:
            writer.write(_line(AdminAnswer(str(error), good=False)))
            return
        writer.write(_line(HEARD))
        await serve(reader, writer)

    async def _read(self, writer: asyncio.StreamWriter) -> None:
        """Wait until the other end has taken what was written.

        Raises:
            TimeoutError: It does not read.
            OSError: It has gone.
        """
        await asyncio.wait_for(writer.drain(), self._read_within_s)

    async def _follow(self, ask: AdminRequest) -> AsyncIterator[str]:
        operating = self._operating
        if ask.verb is AdminVerb.STATUS:
            if ask.wants_json:
                yield operating.status_json(ask.names)
            else:
                yield "\n".join(operating.status(ask.names))
        elif ask.verb is AdminVerb.STOP:
            async for text in operating.stop(ask.names):
                yield text
        else:
            for text in await operating.do(ask):
                yield text


async def _first_line(reader: asyncio.StreamReader) -> bytes:
    """Return what was asked, of one that is too long nothing.

    That one is heard out all the same: whoever is hung up on while still talking does not
    hear the answer.

    Raises:
        EOFError: There is no whole line.
    """
    whole = True
    while True:
        try:
            line = await reader.readuntil(b"\n")
        except asyncio.LimitOverrunError as longer:
            whole = False
            await reader.readexactly(longer.consumed)
        else:
            return line if whole else b""


def peer_uid(connection: socket.socket) -> int:
    """Return the user on the other end, as the kernel says."""
    size = struct.calcsize("3i")
    _, uid, _ = struct.unpack(
        "3i", connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
    )
    return int(uid)


def _number(path: Path) -> tuple[int, int]:
    status = path.lstat()
    return status.st_dev, status.st_ino


def _line(answer: AdminAnswer) -> bytes:
    return encode(answer) + b"\n"
