"""One answer over HTTP/1.1, collected within fixed bounds, whatever the other side sends.

The bytes go into one buffer that was made before; where it is full, the connection is cut off.
"""

from __future__ import annotations

import asyncio
import re
from typing import Final, cast

from rosic.contracts.interpreter import ANSWER_BYTES, AnswerKind

HEAD_BYTES: Final = 8 * 1024
OK: Final = b"200"
_END_OF_HEAD: Final = b"\r\n\r\n"
_LAST_CHUNK: Final = b"0\r\n\r\n"
_STATUS: Final = re.compile(rb"HTTP/1\.[01] (\d{3})(?: [^\r\n]*)?")
_HEADER: Final = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([^\r\n]*?)[ \t]*")
_LENGTH: Final = re.compile(rb"\d{1,9}")
_CHUNK: Final = re.compile(rb"([0-9A-Fa-f]{1,8})[ \t]*(?:;[^\r\n]*)?\r\n")


class FailedResponse(Exception):
    """No answer came of a call.

    Attributes:
        kind: What came instead.
    """

    def __init__(self, kind: AnswerKind) -> None:
        super().__init__(kind.value)
        self.kind = kind


class HttpAnswer(asyncio.BufferedProtocol):
    """Collects the body of one answer.

    Attributes:
        body: Done with the bytes, or with an `FailedResponse`. The connection is cut off by then.
    """

    def __init__(self) -> None:
        self.body: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._buffer = bytearray(HEAD_BYTES + ANSWER_BYTES)
        self._filled = 0
        self._head_ends = 0
        self._length: int | None = None
        self._chunked = False
        self._transport: asyncio.WriteTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep what can be cut off."""
        self._transport = cast("asyncio.WriteTransport", transport)

    def get_buffer(self, sizehint: int) -> memoryview:  # noqa: ARG002 - the loop's signature
        """Return where the next bytes go."""
        return memoryview(self._buffer)[self._filled :]

    def buffer_updated(self, nbytes: int) -> None:
        """Look whether the answer is whole, or can be none."""
        if self.body.done():
            return
        seen, self._filled = self._filled, self._filled + nbytes
        try:
            if not self._head_ends and not self._read_head(max(0, seen - 3)):
                return
            body = self._whole()
        except FailedResponse as failure:
            self._end(failure)
            return
        if body is not None:
            self._end(body)
        elif self._filled - self._head_ends > ANSWER_BYTES or self._filled == len(self._buffer):
            self._end(FailedResponse(AnswerKind.TOO_LARGE))

    def eof_received(self) -> bool:
        """Take what came for the whole, where nothing says how long it is."""
        unmeasured = self._head_ends and self._length is None and not self._chunked
        if unmeasured:
            self._end(bytes(self._buffer[self._head_ends : self._filled]))
        else:
            self._end(FailedResponse(AnswerKind.UNREACHABLE))
        return False

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - the loop's signature
        """Have no answer where none was whole before."""
        self._end(FailedResponse(AnswerKind.UNREACHABLE))

    def cut_off(self) -> None:
        """End the connection at once, and have no answer if none was whole before."""
        self._end(FailedResponse(AnswerKind.LATE))

    def _end(self, came: bytes | FailedResponse) -> None:
        if not self.body.done():
            if isinstance(came, bytes):
                self.body.set_result(came)
            else:
                self.body.set_exception(came)
                self.body.exception()  # whoever asked may have gone
        if self._transport is not None:
            self._transport.abort()

    def _read_head(self, from_: int) -> bool:
        """Return whether the head is there, and read it once.

        Raises:
            FailedResponse: It is too long, or announces nothing that is read.
        """
        at = self._buffer.find(_END_OF_HEAD, from_, self._filled)
        if at < 0:
            if self._filled > HEAD_BYTES:
                raise FailedResponse(AnswerKind.TOO_LARGE)
            return False
        if at > HEAD_BYTES:
            raise FailedResponse(AnswerKind.TOO_LARGE)
        self._head_ends = at + len(_END_OF_HEAD)
        status, *lines = bytes(self._buffer[:at]).split(b"\r\n")
        found = _STATUS.fullmatch(status)
        if found is None:
            raise FailedResponse(AnswerKind.UNREADABLE)
        if found[1] != OK:  # a redirect, too: nothing is followed
            raise FailedResponse(AnswerKind.REFUSED)
        self._read_headers(lines)
        return True

    def _read_headers(self, lines: list[bytes]) -> None:
        for line in lines:
            header = _HEADER.fullmatch(line)
            if header is None:
                raise FailedResponse(AnswerKind.UNREADABLE)
            self._read_header(header[1].lower(), header[2].lower())
        if self._chunked:
            self._length = None
        elif self._length is not None and self._length > ANSWER_BYTES:
            raise FailedResponse(AnswerKind.TOO_LARGE)

    def _read_header(self, name: bytes, value: bytes) -> None:
        if name == b"content-length":
            if not _LENGTH.fullmatch(value) or self._length not in {None, int(value)}:
                raise FailedResponse(AnswerKind.UNREADABLE)
            self._length = int(value)
        elif name == b"transfer-encoding":
            if value != b"chunked":
                raise FailedResponse(AnswerKind.UNREADABLE)
            self._chunked = True
        elif name == b"content-encoding" and value not in {b"", b"identity"}:
            raise FailedResponse(AnswerKind.UNREADABLE)

    def _whole(self) -> bytes | None:
        """Return the body if all of it is there.

        Raises:
            FailedResponse: Its chunks are none.
        """
        if self._chunked:
            if not self._buffer.endswith(_LAST_CHUNK, self._head_ends, self._filled):
                return None
            return dechunked(bytes(self._buffer[self._head_ends : self._filled]))
        if self._length is None or self._filled - self._head_ends < self._length:
            return None
        return bytes(self._buffer[self._head_ends : self._head_ends + self._length])


def dechunked(coded: bytes) -> bytes | None:
    """Return what chunks carry; None where the last is not there yet.

    Raises:
        FailedResponse: They are none.
    """
    parts: list[bytes] = []
    at = 0
    while at < len(coded):
        size = _CHUNK.match(coded, at)
        if size is None:
            raise FailedResponse(AnswerKind.UNREADABLE)
        length, begins = int(size[1], 16), size.end()
        if length == 0:
            return b"".join(parts)
        ends = begins + length
        if ends + 2 > len(coded):
            return None
        if coded[ends : ends + 2] != b"\r\n":
            raise FailedResponse(AnswerKind.UNREADABLE)
        parts.append(coded[begins:ends])
        at = ends + 2
    return None
