"""A person at matrix-js-sdk, in a process of its own: what Element is made of, and as strict."""

from __future__ import annotations

import asyncio
import base64
import json
import time
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from tests.pace import pace
from tests.real.matrix.person import Seen
from tests.servers import needed, node_modules

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from tests.real.matrix.synapse import Account

SCRIPT: Final = Path(__file__).with_suffix(".mjs")
WITHIN_S: Final = 60.0
_ENDS_WITHIN_S: Final = 10.0
_ASKS_EVERY_S: Final = 0.05
_LONGEST_LINE: Final = 64 * 2**20


class JsError(Exception):
    """The client refused, or the homeserver did."""


class JsClient:
    """One device of a user, with its identity set up as Element does it. Its keys are in memory.

    Attributes:
        user: As in ``@ada1:rosic.test``.
        device: The identifier of this device, once it is logged in.
    """

    def __init__(
        self, account: Account, log: Path, *, strict: bool = True, sign: bool = True
    ) -> None:
        """Prepare a device; nothing is started.

        Args:
            account: Whose it is.
            log: A file for what its libraries say.
            strict: Share no key with a device that its owner has not signed; read nothing of it.
            sign: Make an identity of the user, and sign this device with it.
        """
        self.user = account.user
        self.device = ""
        self._account = account
        self._log = log
        self._start = {"strict": strict, "sign": sign}
        self._numbers = count(1)
        self._waiting: dict[int, asyncio.Future[Any]] = {}

    async def __aenter__(self) -> Self:
        with self._log.open("wb") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(needed("node"), str(SCRIPT), str(node_modules())),
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
                limit=_LONGEST_LINE,
            )
        self._reading = asyncio.create_task(self._read())
        account = {"user": self.user, "password": self._account.password}
        try:
            where = {"url": self._account.url, "device": "element"}
            self.device = (await self.ask("start", **account, **where, **self._start))["device"]
        except BaseException:
            await self._end()
            raise
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self._end()

    async def ask(self, command: str, **given: object) -> Any:  # noqa: ANN401 - see the script
        """Let it do something that the script has a name for; return what came of it.

        Raises:
            JsError: It could not; says why.
        """
        assert self._process.stdin is not None
        number = next(self._numbers)
        self._waiting[number] = asyncio.get_running_loop().create_future()
        line = json.dumps({"id": number, "do": command, **given})
        self._process.stdin.write(f"{line}\n".encode())
        async with asyncio.timeout(WITHIN_S * pace()):
            return await self._waiting[number]

    # ---- rooms and messages ----

    async def create_room(
        self, *invited: str, encrypted: bool = True, direct: bool = False, name: str = ""
    ) -> str:
        """Create a room whose members alone may read it; return its identifier."""
        asked = {"encrypted": encrypted, "direct": direct, "name": name}
        room = str(await self.ask("create_room", invite=invited, **asked))
        await self._until_in(room)
        return room

    async def join(self, room: str) -> None:
        """Accept an invitation, and read what stands there."""
        await self.ask("join", room=room)
        await self._until_in(room)

    async def say(self, room: str, text: str, *, reply_to: str = "", thread: str = "") -> str:
        """Write a message, and return its event."""
        asked = {"text": text, "reply_to": reply_to, "thread": thread}
        return str(await self.ask("say", room=room, **asked))

    async def edit(self, room: str, event: str, text: str) -> str:
        """Change a message of one's own."""
        return str(await self.ask("edit", room=room, event=event, text=text))

    async def react(self, room: str, event: str, key: str) -> str:
        """Put a reaction beneath a message."""
        return str(await self.ask("react", room=room, event=event, key=key))

    async def redact(self, room: str, event: str) -> None:
        """Take back a message or a reaction."""
        await self.ask("redact", room=room, event=event)

    async def send_file(self, room: str, name: str, content: bytes, mime: str = "") -> str:
        """Send a file, encrypted where the room is; return its event."""
        told = {"name": name, "base64": base64.b64encode(content).decode()}
        return str(
            await self.ask("send_file", room=room, **told, **({"mime": mime} if mime else {}))
        )

    async def file(self, room: str, event: str) -> bytes:
        """Return the file of a message, decrypted."""
        return base64.b64decode(await self.ask("file", room=room, event=event))

    async def sees(self, room: str, sender: str = "") -> list[JsSeen]:
        """Return the messages in a room as they are shown now, oldest first.

        Args:
            room: Which one.
            sender: Only theirs; everybody's by default.
        """
        found = [JsSeen(told) for told in await self.ask("sees", room=room)]
        return [seen for seen in found if not sender or seen.sender == sender]

    async def until(
        self, room: str, shown: Callable[[list[JsSeen]], bool], within_s: float = WITHIN_S
    ) -> list[JsSeen]:
        """Wait until what is shown in a room is as it should be, and return it."""
        give_up_s = time.monotonic() + within_s * pace()
        while not shown(found := await self.sees(room)):
            assert time.monotonic() < give_up_s, f"it is never shown, but {found}"
            await asyncio.sleep(_ASKS_EVERY_S)
        return found

    async def hears(self, room: str, text: str) -> JsSeen:
        """Wait until there is a message with this text, and return it."""
        found = await self.until(room, lambda seen: any(one.text == text for one in seen))
        return next(one for one in found if one.text == text)

    # ---- trust ----

    async def trust(self, user: str, device: str = "") -> dict[str, bool]:
        """Return what it makes of a user, and of a device of theirs.

        ``user_verified``: their identity is, by emoji. ``needs_approval``: it has changed since.
        ``signed_by_owner``, ``device_verified``: the device, where one is given.
        """
        told: dict[str, bool] = await self.ask("trust", user=user, device=device)
        return told

    async def verified(self, user: str) -> None:
        """Wait until a user is verified: they are a moment after their verification is done."""
        give_up_s = time.monotonic() + WITHIN_S * pace()
        while not (await self.trust(user))["user_verified"]:
            assert time.monotonic() < give_up_s, f"{user} is not verified"
            await asyncio.sleep(_ASKS_EVERY_S)

    async def request_verification(self, user: str, *, room: str = "", device: str = "") -> str:
        """Ask somebody to compare emoji, in a room or device to device; return the transaction."""
        asked = {"room": room, "device": device}
        return str(await self.ask("request_verification", user=user, **asked))

    async def verification(self, user: str, phase: str) -> dict[str, Any]:
        """Wait until a verification with somebody is in this phase, and return it.

        Args:
            user: The other one.
            phase: ``requested``, ``ready``, ``started``, ``emoji``, ``cancelled`` or ``done``.
        """
        give_up_s = time.monotonic() + WITHIN_S * pace()
        while True:
            found = [one for one in await self.ask("verifications") if one["user"] == user]
            for one in found:
                if phase in (one["phase"], "emoji" if one["emoji"] else ""):
                    told: dict[str, Any] = one
                    return told
            assert time.monotonic() < give_up_s, f"the verification never was {phase}: {found}"
            await asyncio.sleep(_ASKS_EVERY_S)

    async def accept_verification(self, transaction: str) -> None:
        """Agree to compare emoji."""
        await self.ask("accept_verification", transaction=transaction)

    async def compare_emoji(self, transaction: str) -> None:
        """Begin to compare emoji, once both have agreed to."""
        await self.ask("compare_emoji", transaction=transaction)

    async def confirm(self, transaction: str) -> None:
        """Say that the emoji are the same."""
        await self.ask("confirm_emoji", transaction=transaction)

    async def reject(self, transaction: str) -> None:
        """Say that the emoji differ."""
        await self.ask("reject_emoji", transaction=transaction)

    # ---- the process ----

    async def _until_in(self, room: str) -> None:
        give_up_s = time.monotonic() + WITHIN_S * pace()
        while (await self.ask("rooms")).get(room) != "join":
            assert time.monotonic() < give_up_s, "the room never came"
            await asyncio.sleep(_ASKS_EVERY_S)

    async def _read(self) -> None:
        assert self._process.stdout is not None
        while line := await self._process.stdout.readline():
            told = json.loads(line)
            waiting = self._waiting.pop(told["id"])
            if waiting.done():
                continue
            if "error" in told:
                waiting.set_exception(JsError(told["error"]))
            else:
                waiting.set_result(told["result"])
        for waiting in self._waiting.values():
            if not waiting.done():
                waiting.set_exception(JsError(f"it ended by itself; see {self._log}"))

    async def _end(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            async with asyncio.timeout(_ENDS_WITHIN_S * pace()):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()
        await self._reading


class JsSeen(Seen):
    """A message as this client shows it now.

    Attributes:
        unreadable: Why it cannot be decrypted; empty where it can.
        shield: What is shown beside it: ``NONE``, ``GREY`` or ``RED``; empty in the plain.
    """

    def __init__(self, told: dict[str, Any]) -> None:
        super().__init__(
            id=told["id"],
            sender=told["sender"],
            kind=told["kind"],
            text=told["text"],
            encrypted=told["encrypted"],
            edits=int(told["edited"]),
            reply_to=told["reply_to"],
            reactions={key: set(senders) for key, senders in told["reactions"].items()},
            content=told["content"],
        )
        self.unreadable: str = told["unreadable"]
        self.shield: str = told["shield"]
