"""Questions at the terminal, each with what is taken when the answer is empty."""

from __future__ import annotations

from rosic.errors import ConfigurationError

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

    def text(self, question: str, default: str) -> str:
        """Ask for a text.

        Raises:
            ConfigurationError: The answers ended before the questions.
        """
        if self._silent:
            return default
        shown = f"{question} [{default}] " if default else f"{question} "
        try:
            return input(shown).strip() or default
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
