"""The messenger itself. Its one person is whoever may use this process's terminal."""

from __future__ import annotations

import asyncio
import os
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple, TextIO

from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.identity import Address
from rosic.core.language.cancel_detection import is_urgent
from rosic.core.message import Chat, Inbound, IncomingFile, Outbound
from rosic.core.time_units import MINUTE_NS, SECOND_NS
from rosic.core.traffic import TrafficCount, TrafficCounter
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.terminal.completion import Completer
from rosic.messengers.terminal.downloads import FILE_BYTES, DownloadFolder
from rosic.messengers.terminal.screen import Interrupted, PlainScreen, Screen, standard_input, write

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Receive
    from rosic.core.language.command import Command
    from rosic.core.message import Button
    from rosic.core.robot.profile import Profile


# ---- numbered buttons ----

# A button is good for 60 s. Until something else is said its number means nothing else for twice
# that, so that a number typed a moment too late never taps a button that has just been shown.
RESERVED_NS = 2 * MINUTE_NS
AT_MOST = 99
# Nobody has read and answered something else in so short a time.
TYPED_WITHIN_NS = SECOND_NS


class Choice(NamedTuple):
    """A button that was shown.

    Attributes:
        message: The message it stood under.
        shown_ns: Monotonic clock.
    """

    button: Button
    message: str
    shown_ns: int


class Choices:
    """Numbers of the buttons that can still be tapped. Bounded: the oldest message goes first."""

    def __init__(self) -> None:
        self._shown: dict[int, Choice] = {}
        self._numbered = 0
        self._last = 0

    def show(self, message: str, outbound: Outbound, now_ns: int) -> str:
        """Number a message's buttons. Return the lines that show them; empty without buttons."""
        rows = []
        for row in outbound.buttons:
            labels = [f"[{self._number(b, message, now_ns)}] {b.label}" for b in row]
            rows.append(f"  {'  '.join(labels)}")
        return "\n".join(rows)

    def _number(self, button: Button, message: str, now_ns: int) -> int:
        for number, choice in list(self._shown.items()):
            if now_ns - choice.shown_ns > RESERVED_NS:
                del self._shown[number]
        if not self._shown:
            self._last = 0
        self._last = self._last % AT_MOST + 1
        self._numbered = max(self._numbered, self._last)
        self._shown.pop(self._last, None)
        self._shown[self._last] = Choice(button, message, now_ns)
        return self._last

    def retire(self, now_ns: int) -> None:
        """Let what was shown before be no choice any more: something else was said since.

        What is answered to that begins with 1 again, and no number on the screen above means it.
        What appeared while it was being typed stays a choice.
        """
        for number, choice in list(self._shown.items()):
            if now_ns - choice.shown_ns > TYPED_WITHIN_NS:
                del self._shown[number]
        if not self._shown:
            self._last = 0

    def take(self, text: str) -> Choice | None:
        """Return the button whose number was typed. Its neighbours are answered with it."""
        taken = self._shown.get(_number_in(text))
        if taken is not None:
            for number, choice in list(self._shown.items()):
                if choice.message == taken.message:
                    del self._shown[number]
        return taken

    def over(self, text: str) -> bool:
        """Whether a number is typed that once stood before a button, and is no choice any more."""
        number = _number_in(text)
        return 0 < number <= self._numbered and number not in self._shown


def _number_in(text: str) -> int:
    """Return the number that a line is; 0 for anything else."""
    word = text.strip()
    if word.isascii() and word.isdecimal() and len(word) <= len(str(AT_MOST)):
        return int(word)
    return 0


# ---- the messenger ----

WAITING_AT_MOST = 256
OVER = "over"  # the nonce of no button: a number that was typed too late is a tap too late


class TerminalMessenger:
    """One terminal, one person: the local user, by number.

    A line is handed over when it is complete; a stop overtakes lines that still wait. A script
    piped into it is a person like any other, only faster.

    Args:
        screen: Where to read and show; None finds out when it is first needed.
        account: The local user's number; None takes that of this process.
        plain: No colours, no prompt that redraws itself.
        locale: What the terminal is set to; only the default for whoever has not chosen.

    Attributes:
        downloads: Where the files lie that it was sent.
        interrupted: Set by each Ctrl-C; see `take_interrupts`.
        ended: Set when there is nothing more to read. `run` goes on: others may still talk.
        gone: What is shown reaches nobody any more; `ended` is set then, too.
    """

    platform = "terminal"
    assurance = "local"
    edits = False
    file_bytes = FILE_BYTES
    fetch_bytes = 0
    pins = False

    def __init__(
        self,
        name: str = "terminal",
        *,
        clock: Clock,
        screen: Screen | None = None,
        account: str | None = None,
        plain: bool = False,
        locale: str = "",
    ) -> None:
        self.name = name
        self.locale = locale
        self.interrupted = asyncio.Event()
        self.ended = asyncio.Event()
        self.gone = False
        self._pace: Callable[[], Awaitable[None]] | None = None
        self.account = str(os.getuid()) if account is None else account
        self._clock = clock
        self._plain = plain
        self._screen = screen
        self._completer = Completer()
        self._choices = Choices()
        self.downloads = DownloadFolder()
        # As a private chat is found by whoever has something to tell: it is the account.
        self._chat = Chat(self.platform, self.account)
        self._serial = 0
        self._traffic = TrafficCounter()
        self._interrupts = 0
        # Ids must not come again in another run: the record remembers them (I1).
        self._run_id = f"{clock.wall_ns():x}-{os.getpid()}"
        self._since_ns = 0
        self._waiting: asyncio.Queue[Inbound] = asyncio.Queue(WAITING_AT_MOST)

    def know(self, profiles: Iterable[Profile], commands: Iterable[Command]) -> None:
        """Complete these commands, and the names and skills of these robots, from now on."""
        self._completer = Completer(profiles, commands)

    def pace_by(self, done: Callable[[], Awaitable[None]]) -> None:
        """Read each line only once what the one before it began is done: for scripts."""
        self._pace = done

    async def run(self, receive: Receive) -> None:
        """Listen until cancelled. See the contract."""
        self._since_ns = self._clock.wall_ns()
        try:
            if self._screen is None:
                self._screen = self._find_screen()
            with self._screen as screen:
                async with asyncio.TaskGroup() as group:
                    group.create_task(self._hand_over(receive))
                    await self._listen(screen, receive, group)
                    self.ended.set()
                    await asyncio.Event().wait()
        except ExceptionGroup as several:
            first = several.exceptions[0]
            raise first from first.__cause__  # whether a pipe broke is asked later

    async def _listen(self, screen: Screen, receive: Receive, group: asyncio.TaskGroup) -> None:
        while (line := await self._next_line(screen)) is not None:
            if not line.strip():
                continue
            self._interrupts = 0
            self._traffic.came(len(line.encode(errors="replace")))
            inbound = self._inbound(line)
            if self._pace is not None:
                await receive(inbound)
                await self._pace()
            elif is_urgent(inbound.text or inbound.nonce or ""):
                group.create_task(_received(receive, inbound))
            elif self._waiting.full():
                screen.show("Too many lines at once. Wait a moment.")
            else:
                self._waiting.put_nowait(inbound)

    async def _next_line(self, screen: Screen) -> str | None:
        try:
            return await screen.read()
        except Interrupted:
            self.interrupt()
            return ""

    @property
    def traffic(self) -> TrafficCount:
        """Return how many lines were typed and how many messages were shown."""
        return self._traffic.count

    @property
    def address(self) -> Address:
        """Whose terminal it is: whoever runs this process."""
        return Address(self.platform, self.account)

    @property
    def at_hand(self) -> bool:
        """Whether somebody types, and no pipe."""
        return is_terminal(sys.stdin)

    def interrupt(self) -> None:
        """Take a Ctrl-C: whoever follows `interrupted` decides what it means."""
        self._interrupts += 1
        self.interrupted.set()

    def take_interrupts(self) -> int:
        """Return how many Ctrl-C came since something was typed, and wait for the next anew."""
        self.interrupted.clear()
        return self._interrupts

    async def _hand_over(self, receive: Receive) -> None:
        while True:
            await receive(await self._waiting.get())

    def _inbound(self, line: str) -> Inbound:
        now_ns = self._clock.wall_ns()
        message = self._next_id()
        choice = self._choices.take(line)
        over = choice is None and self._choices.over(line)
        if choice is None and not over:
            self._choices.retire(self._clock.monotonic_ns())
        return Inbound(
            sender=self.address,
            chat=self._chat,
            message=message,
            text="" if choice or over else line,
            nonce=choice.button.nonce if choice else OVER if over else None,
            tap=f"tap-{message}" if choice or over else "",
            under=choice.message if choice else "",
            locale=self.locale,
            sent_ns=now_ns,
            received_ns=now_ns,
            listening_since_ns=self._since_ns,
        )

    async def send(self, outbound: Outbound) -> str:
        """Show a text, where its file lies, and its choices. See the contract."""
        message = self._next_id()
        if outbound.attachment is not None:
            lies = await self.downloads.put(outbound.attachment, outbound.lies_in)
            outbound = replace(outbound, text=f"{outbound.text}\n{lies}".strip())
        if self.ended.is_set():  # nobody types any more, so nothing can be chosen
            outbound = replace(outbound, buttons=())
        choices = self._choices.show(message, outbound, self._clock.monotonic_ns())
        shown = f"{outbound.text}\n{choices}" if choices else outbound.text
        self.show(shown)
        self._traffic.went(len(shown.encode(errors="replace")))
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:  # noqa: ARG002 - the contract
        """Refuse: what was printed stays printed.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault("A terminal cannot change what it has shown.")

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:  # noqa: ARG002
        """Refuse: a terminal scrolls.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault(said("A terminal cannot keep a message in sight."))

    async def answer_tap(self, inbound: Inbound, text: str) -> None:  # noqa: ARG002 - the contract
        """Show the answer, if there is one."""
        if text:
            with suppress(MessengerFault):
                self.show(text)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:  # noqa: ARG002 - the contract
        """Refuse: nobody encloses anything in a line.

        Raises:
            MessengerFault: Always.
        """
        raise MessengerFault("No file can be sent over a terminal.")

    def show(self, text: str) -> None:
        """Show something that need not be part of a conversation: a greeting, a farewell.

        Raises:
            MessengerFault: There is nobody to show it to.
        """
        try:
            if self._screen is not None:
                self._screen.show(text)
            else:
                write(text, colour=self._colour())  # nobody listens yet: there is no prompt yet
        except MessengerFault:
            self.gone = True
            self.ended.set()  # nobody reads any more, so nobody is there to type
            raise

    def _next_id(self) -> str:
        self._serial += 1
        return f"{self._run_id}-{self._serial}"

    def _colour(self) -> bool:
        return not self._plain and is_terminal(sys.stdout) and not os.environ.get("NO_COLOR")

    def _find_screen(self) -> Screen:
        colour = self._colour()
        at_hand = is_terminal(sys.stdin)
        if at_hand and is_terminal(sys.stdout) and not self._plain and _can_draw():
            from rosic.messengers.terminal.prompt import PromptScreen  # noqa: PLC0415 - 0.3 s

            return PromptScreen(self._completer, colour=colour)
        return PlainScreen(standard_input(), echo=not at_hand, colour=colour)


async def _received(receive: Receive, inbound: Inbound) -> None:
    await receive(inbound)


def is_terminal(stream: TextIO | None) -> bool:
    """Whether a person is at the other end of a standard stream."""
    try:
        return stream is not None and stream.isatty()
    except ValueError:
        return False  # closed


def own_locale(*, at_hand: bool | None = None) -> str:
    """Return what the terminal of a person is set to; empty where programmes read and write.

    Args:
        at_hand: Whether there is a person; None finds out.
    """
    if at_hand is None:
        at_hand = is_terminal(sys.stdin) and is_terminal(sys.stdout)
    if not at_hand:
        return ""
    names = ("LC_ALL", "LC_MESSAGES", "LANG")
    locale = next(filter(None, (os.environ.get(name, "") for name in names)), "")
    return locale.partition(".")[0].partition("@")[0]


def _can_draw() -> bool:
    return os.environ.get("TERM", "dumb") != "dumb"


def terminal_messenger(name: str, settings: Mapping[str, Any], clock: Clock) -> TerminalMessenger:
    """Make it from its table in the configuration: ``plain = true`` is all there is to set.

    Raises:
        ConfigurationError: A setting is unknown or wrong; the sentence names it.
    """
    unknown = sorted(set(settings) - {"kind", "name", "plain"})
    if unknown:
        raise ConfigurationError(
            f"The messenger {name} does not know the setting {unknown[0]}.",
            hint="It knows: plain.",
        )
    plain = settings.get("plain", False)
    if not isinstance(plain, bool):
        raise ConfigurationError(f"plain of the messenger {name} must be true or false.")
    return TerminalMessenger(name, clock=clock, plain=plain, locale=own_locale())
