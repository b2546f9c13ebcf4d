"""A real HTTP server that answers as a test says, on a thread of its own and a free port."""

from __future__ import annotations

import json
import socket
import ssl
import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from rosic.core.secret import Secret
from rosic.interpreters.chat_completions import ChatCompletions, InterpreterSettings
from rosic.interpreters.endpoint import parse_endpoint

if TYPE_CHECKING:
    from collections.abc import Callable

    Script: TypeAlias = Callable[["Call"], None]

MODEL = "small-1"


class Call:
    """One call, as the server received it, and the connection that it came over.

    Attributes:
        head: Of the request, as text.
        body: Of the request, decoded.
        ended: Set when the server is closed: what waits ends then.
    """

    def __init__(
        self, connection: socket.socket, head: str, body: dict[str, Any], ended: threading.Event
    ) -> None:
        self.head, self.body, self.ended = head, body, ended
        self._connection = connection

    @property
    def text(self) -> str:
        """What somebody wrote."""
        return str(self.body["messages"][1]["content"])

    @property
    def instructions(self) -> str:
        """What may be said."""
        return str(self.body["messages"][0]["content"])

    @property
    def whole(self) -> str:
        """Everything that left the house."""
        return f"{self.head}\n{json.dumps(self.body, ensure_ascii=False)}"

    def send(self, data: bytes) -> bool:
        """Send bytes; whether the other side still takes them."""
        try:
            self._connection.sendall(data)
        except OSError:
            return False
        return True

    def reset(self) -> None:
        """Break the connection, unsent bytes and all."""
        linger = (1).to_bytes(4, "little") + (0).to_bytes(4, "little")
        self._connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)


class ScriptedEndpoint:
    """Listens; each connection is one call.

    Attributes:
        calls: In the order in which they came.
        script: Answers a call. Whoever sets it does so before the call.
    """

    def __init__(self, script: Script, *, tls: ssl.SSLContext | None = None) -> None:
        self.script = script
        self._tls = tls
        self.calls: list[Call] = []
        self._ended = threading.Event()
        self._listening = socket.create_server(("127.0.0.1", 0))
        self._threads: list[threading.Thread] = []
        self._connections: list[socket.socket] = []
        self._accepting = threading.Thread(target=self._accept, daemon=True)

    def __enter__(self) -> Self:
        self._accepting.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        # An accept that waits is not woken by close alone.
        with socket.socket() as last:
            last.connect(self._listening.getsockname())
        self._accepting.join()
        self._listening.close()
        for connection in self._connections:
            with suppress(OSError):  # closed already
                connection.shutdown(socket.SHUT_RDWR)  # wakes who still sends
        for thread in self._threads:
            thread.join()

    @property
    def idle(self) -> bool:
        """Whether every call has been answered to its end, or was cut off."""
        return not any(thread.is_alive() for thread in self._threads)

    @property
    def address(self) -> str:
        """Where it listens."""
        scheme = "http" if self._tls is None else "https"
        return f"{scheme}://127.0.0.1:{self._listening.getsockname()[1]}"

    def client(self, *, key: str = "", timeout_s: float = 60.0) -> ChatCompletions:
        """Return an adapter to it."""
        return client_of(self.address, key=key, timeout_s=timeout_s)

    def _accept(self) -> None:
        while True:
            connection, _ = self._listening.accept()
            if self._ended.is_set():
                connection.close()
                return
            if self._tls is not None:
                connection = self._tls.wrap_socket(
                    connection, server_side=True, do_handshake_on_connect=False
                )
            self._connections.append(connection)
            thread = threading.Thread(target=self._serve, args=(connection,), daemon=True)
            self._threads.append(thread)
            thread.start()

    def _serve(self, connection: socket.socket) -> None:
        with connection:
            try:
                if isinstance(connection, ssl.SSLSocket):
                    connection.do_handshake()
                call = self._read(connection)
            except OSError:
                return
            if call is not None:
                self.calls.append(call)
                self.script(call)

    def _read(self, connection: socket.socket) -> Call | None:
        data = b""
        while b"\r\n\r\n" not in data:
            data += (piece := connection.recv(65_536))
            if not piece:
                return None
        head, _, body = data.partition(b"\r\n\r\n")
        (length,) = (
            int(line.split(b":")[1])
            for line in head.split(b"\r\n")
            if line.lower().startswith(b"content-length:")
        )
        while len(body) < length:
            body += connection.recv(65_536)
        return Call(connection, head.decode(), json.loads(body), self._ended)


def client_of(address: str, *, key: str = "", timeout_s: float = 60.0) -> ChatCompletions:
    """Return an adapter to what listens at an address, if anything does."""
    settings = InterpreterSettings(
        endpoint=parse_endpoint(address),
        model=MODEL,
        key=Secret(key) if key else None,
        timeout_s=timeout_s,
    )
    return ChatCompletions(settings)


def http(body: bytes, *, status: str = "200 OK", more: str = "") -> bytes:
    """Return an answer with its length."""
    head = f"HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n"
    return f"{head}{more}\r\n".encode() + body


def completion(content: object) -> bytes:
    """Return the body of a good answer that says something."""
    choice = {"index": 0, "message": {"role": "assistant", "content": content}}
    return json.dumps({"id": "1", "object": "chat.completion", "choices": [choice]}).encode()


def saying(content: object) -> Script:
    """Answer each call with the same words, well formed."""

    def answer(call: Call) -> None:
        call.send(http(completion(content)))

    return answer
