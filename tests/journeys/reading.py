"""What a person can read in a chat: how a command ended, by the words of the replies alone."""

from __future__ import annotations

import enum
import re
from typing import TYPE_CHECKING, Any, Final

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterable

SAID_AGAIN = "(Said again: ROSIC was restarted.)"
PERHAPS_TWICE = "(This may stand here twice: the connection broke.)"
MARKS = frozenset((SAID_AGAIN, PERHAPS_TWICE))


class End(enum.Enum):
    """How a command ended, as it was told."""

    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"
    UNKNOWN = "unknown"
    EXPIRED = "expired"
    REFUSED = "refused"


# How many times a robot may have acted, by what was told (I7).
ACTED: Final = {
    End.DONE: (1, 1),
    End.FAILED: (1, 1),
    End.CANCELLED: (0, 1),
    End.UNKNOWN: (0, 1),
    End.EXPIRED: (0, 0),
    End.REFUSED: (0, 0),
}

_LINES: Final = (
    (End.DONE, r"done \d\d:"),
    (End.FAILED, r"failed \d\d:"),
    (End.CANCELLED, r"stopped before it ended"),
    (End.UNKNOWN, r"not known whether it was carried out|It may or may not have been carried out"),
    (
        End.EXPIRED,
        (
            r"Your command is .* old"
            r"|You sent this while (?:I could not listen|the network was away)"
            r"|was busy for too long|This reached .* too late"
        ),
    ),
    (
        End.REFUSED,
        (
            r"is busy:|commands waiting already|was stopped before this could begin"
            r"|(?:is|are) stopped|What came before this was broken off"
            r"|is taken by|has already acted on a later command|Somebody else has"
            r"|I cannot write down what is decided"
        ),
    ),
)
_ENDINGS: Final = tuple((end, re.compile(words)) for end, words in _LINES)
_SUMMARY: Final = re.compile(r"While (?:I could not listen|the network was away), (\d+) command")
_UNDER_WAY: Final = re.compile(r"(accepted|waiting its turn|sent|received by the robot) ")


class Reply(msgspec.Struct, frozen=True):
    """One message of the bot, with its history.

    Attributes:
        endings: Of each form it had, how lives ended according to it, line by line.
        strange: Lines that say neither how far a life is nor how it ended.
        again: It is marked as perhaps said before.
        summarised: Of how many commands it says that they were not carried out.
    """

    text: str
    endings: tuple[tuple[End, ...], ...]
    strange: tuple[str, ...]
    again: bool
    summarised: int = 0

    @property
    def last(self) -> tuple[End, ...]:
        """The endings it shows now."""
        return self.endings[-1]


def read_reply(message: dict[str, Any]) -> Reply:
    """Read one message of the fake server's record."""
    texts = [str(version["text"]) for version in message["versions"]]
    return Reply(
        texts[-1],
        tuple(tuple(_endings(text)) for text in texts),
        tuple(_strange(texts[-1])),
        any(mark in texts[-1] for mark in MARKS),
        summarised(message),
    )


def summarised(message: dict[str, Any]) -> int:
    """Return of how many commands a message says that they were not carried out."""
    found = _SUMMARY.match(str(message["text"]))
    return int(found[1]) if found else 0


def _endings(text: str) -> list[End]:
    return [end for line in text.splitlines() if (end := _ending(line)) is not None]


def _ending(line: str) -> End | None:
    return next((end for end, words in _ENDINGS if words.search(line)), None)


def _strange(text: str) -> Iterable[str]:
    for line in text.splitlines():
        title = re.match(r"\S+:( |$)", line)
        if not (_ending(line) or _UNDER_WAY.match(line) or title or line in MARKS):
            yield line
