"""A text that nobody prints by accident: tokens, passwords, keys."""

from __future__ import annotations

from hmac import compare_digest
from typing import Final, NoReturn

MASK: Final = "***"


class Secret:
    """Holds a secret and shows ``***`` wherever it is printed, formatted or logged.

    It is no ``str`` on purpose: joining it into a text, encoding it as JSON and pickling it raise
    ``TypeError`` instead of leaking. Only `reveal` gives the text, at the last moment.
    """

    __slots__ = ("_text",)

    def __init__(self, text: str) -> None:
        if not text:
            raise ValueError("a secret is never empty")
        self._text = text

    def reveal(self) -> str:
        """Return the text itself; keep it in no variable that outlives its use."""
        return self._text

    def __repr__(self) -> str:
        return MASK

    def __format__(self, spec: str) -> str:
        return format(MASK, spec)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Secret):
            return NotImplemented
        return compare_digest(self._text.encode(), other._text.encode())

    def __hash__(self) -> int:
        return hash(self._text)

    def __copy__(self) -> Secret:
        return self

    def __deepcopy__(self, memo: object) -> Secret:
        return self

    def __getstate__(self) -> NoReturn:
        raise TypeError("a secret is not copied out of this process")
