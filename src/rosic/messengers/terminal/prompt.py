"""The prompt: completion, history, and output above the line that is being typed."""

from __future__ import annotations

import os
import termios
from contextlib import ExitStack, contextmanager
from shutil import get_terminal_size
from textwrap import fill
from typing import TYPE_CHECKING, Self

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import Completer as ToolkitCompleter
from prompt_toolkit.completion import Completion as ToolkitCompletion
from prompt_toolkit.history import InMemoryHistory
from prompt_toolkit.output import ColorDepth
from prompt_toolkit.patch_stdout import patch_stdout

from rosic.messengers.terminal.screen import Interrupted, write

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager
    from types import TracebackType

    from prompt_toolkit.completion import CompleteEvent
    from prompt_toolkit.document import Document

    from rosic.messengers.terminal.completion import Completer

PROMPT = "> "
NARROWEST = 20
_CONTROL_CHARACTERS = 6
"""Their place in what `termios.tcgetattr` returns."""
LEAVE = frozenset({"exit", "quit"})


class _Completing(ToolkitCompleter):
    def __init__(self, completer: Completer) -> None:
        self.ours = completer

    def get_completions(
        self,
        document: Document,
        complete_event: CompleteEvent,  # noqa: ARG002 - its signature
    ) -> Iterator[ToolkitCompletion]:
        # What goes on after a word goes on after its blank; after "=", at once.
        blank = "" if document.text_after_cursor[:1].isspace() else " "
        for found in self.ours.complete(document.text_before_cursor):
            yield ToolkitCompletion(
                found.text if found.text.endswith("=") else f"{found.text}{blank}",
                start_position=-found.replaces,
                display=found.text,
                display_meta=found.meta,
            )


class PromptScreen:
    """A terminal with a person in front of it. What was typed before is kept for this run only."""

    def __init__(self, completer: Completer, *, colour: bool) -> None:
        self._colour = colour
        self._session: PromptSession[str] = PromptSession(
            PROMPT,
            completer=_Completing(completer),
            complete_while_typing=True,
            history=InMemoryHistory(),
            color_depth=None if colour else ColorDepth.DEPTH_1_BIT,
            reserve_space_for_menu=6,
        )
        self._above: AbstractContextManager[None] = patch_stdout(raw=True)
        self._raw: ExitStack | None = None

    def __enter__(self) -> Self:
        self._above.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._cook()
        self._above.__exit__(kind, error, at)

    async def read(self) -> str | None:
        """Return the next line; None after Ctrl-D, exit or quit.

        Raises:
            Interrupted: After Ctrl-C, whatever had been typed.
        """
        if self._raw is None:
            # Between two lines as well: a Ctrl-D that a terminal in its usual mode takes is lost.
            self._raw = ExitStack()
            self._raw.enter_context(_without_end_of_file(self._session.input.fileno()))
            self._raw.enter_context(self._session.input.raw_mode())
        line = await self._line()
        if line is None:
            self._cook()
        return line

    def _cook(self) -> None:
        """Let the terminal make signals of keys again: nobody reads any more."""
        if self._raw is not None:
            self._raw.close()
            self._raw = None

    async def _line(self) -> str | None:
        try:
            line = await self._session.prompt_async(
                handle_sigint=False, set_exception_handler=False
            )
        except EOFError:
            return None
        except KeyboardInterrupt as pressed:
            raise Interrupted from pressed
        return None if line.strip().casefold() in LEAVE else line

    def show(self, text: str) -> None:
        """Print above the prompt, broken between words where the terminal would break a word."""
        width = get_terminal_size().columns
        lines = [wrapped(line, width) for line in text.split("\n")]
        write("\n".join(lines), colour=self._colour)


@contextmanager
def _without_end_of_file(terminal: int) -> Iterator[None]:
    """Let a Ctrl-D be a key like any other, in the terminal's usual mode too.

    Whatever is printed above the prompt is printed in that mode, and a terminal that takes a
    Ctrl-D for the end of its input then hands over a NUL instead: the key would be lost.
    """
    before = termios.tcgetattr(terminal)
    changed = termios.tcgetattr(terminal)
    changed[_CONTROL_CHARACTERS][termios.VEOF] = os.fpathconf(terminal, "PC_VDISABLE").to_bytes()
    termios.tcsetattr(terminal, termios.TCSANOW, changed)
    try:
        yield
    finally:
        termios.tcsetattr(terminal, termios.TCSANOW, before)


def wrapped(line: str, width: int) -> str:
    """Return a line of at most ``width`` columns each; a word longer than that stays whole."""
    if len(line) < width or width < NARROWEST:
        return line
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    return fill(
        line,
        width - 1,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
        drop_whitespace=True,
    )
