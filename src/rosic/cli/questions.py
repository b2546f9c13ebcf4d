"""Questions at the terminal, each with what is taken when the answer is empty."""

from __future__ import annotations

import sys
from getpass import getpass
from typing import TYPE_CHECKING

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Callable

HIDDEN = "Nothing is shown while you type or paste the next answer; Enter ends it."
_YES = {"y": True, "yes": True, "n": False, "no": False}


class Questions:
    """Asks somebody, or nobody.

    Args:
        silent: Ask nothing: every answer is empty.
    """

    def __init__(self, *, silent: bool) -> None:
        self._silent = silent

    def say(self, sentence: str) -> None:
        """Tell something between two questions."""
        print(sentence)

    def fit(
        self, question: str, default: str, check: Callable[[str], object], *, secret: bool = False
    ) -> str:
        """Ask for a text, again until it fits: one slip of a finger costs no other answer.

        Args:
            question: What is asked.
            default: For an empty answer.
            check: Raises a ConfigurationError about an answer that does not fit.
            secret: Do not show what is typed.

        Raises:
            ConfigurationError: The answers ended before the questions; or nothing is asked, and
                the default does not fit.
        """
        while True:
            answer = self.text(question, default, secret=secret)
            try:
                check(answer)
            except ConfigurationError as wrong:
                if self._silent:
                    raise
                self.say(str(wrong))
            else:
                return answer

    def text(self, question: str, default: str, *, secret: bool = False) -> str:
        """Ask for a text.

        Args:
            question: What is asked.
            default: For an empty answer.
            secret: Do not show what is typed.

        Raises:
            ConfigurationError: The answers ended before the questions.
        """
        if self._silent:
            return default
        shown = f"{question} [{default}] " if default else f"{question} "
        try:
            hidden = secret and sys.stdin.isatty()
            if hidden:
                self.say(HIDDEN)
            return (getpass(shown) if hidden else input(shown)).strip() or default
        except EOFError:
            print()
            raise ConfigurationError(
                "The questions were not answered to the end. Nothing was written.",
                hint="rosic init --yes asks nothing.",
            ) from None

    def yes(self, question: str, *, default: bool) -> bool:
        """Ask for yes or no, again until it is one of them."""
        while True:
            said = self.text(f"{question} {'[Y/n]' if default else '[y/N]'}", "")
            answer = default if not said else _YES.get(said.casefold())
            if answer is not None:
                return answer
            self.say("Please say yes or no.")
