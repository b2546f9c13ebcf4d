"""What can go wrong with a call to a homeserver, as one type of ours that holds nothing of theirs.

No foreign exception is chained: aiohttp puts addresses into messages, and an access token may be
part of one.
"""

from __future__ import annotations

import enum
import logging
from typing import TYPE_CHECKING, Final

from nio.exceptions import LocalProtocolError, OlmTrustError

from rosic.errors import MessengerFault, RosicError

if TYPE_CHECKING:
    from collections.abc import Mapping

log = logging.getLogger("rosic.messengers.matrix")

DEFAULT_WAIT_S: Final = 1.0
LONGEST_REASON: Final = 200


class MatrixErrorKind(enum.Enum):
    """What a caller can do about it."""

    UNUSABLE = "the account cannot be used"
    SIGNED_OUT = "the access token counts no longer; a new one may be had"
    TOO_FAST = "wait, then try again"
    FORBIDDEN = "this account may not do it there"
    REFUSED = "this call will never succeed"
    NOT_FOUND = "there is no such thing"
    TOO_LARGE = "its answer is more than can be read at once; less may be asked for"
    LOST = "it may or may not have arrived"


class MatrixError(MessengerFault):
    """A call to the homeserver did not succeed.

    Attributes:
        kind: What a caller can do.
        reason: What the homeserver or the network said; for the log.
        errcode: Matrix's own name for it: ``M_FORBIDDEN``; empty for none.
        wait_s: How long the homeserver asks to wait.
        soft: Of a token that counts no longer: the device is still there, with its keys.
        body: The answer as it came; what else must be done stands in it.
    """

    def __init__(
        self,
        sentence: str,
        kind: MatrixErrorKind,
        reason: str,
        *,
        errcode: str = "",
        wait_s: float = 0.0,
    ) -> None:
        super().__init__(sentence)
        self.kind = kind
        self.reason = reason[:LONGEST_REASON]
        self.errcode = errcode
        self.wait_s = wait_s
        self.soft = False
        self.body: Mapping[str, object] = {}
        self.perhaps_sent = kind is MatrixErrorKind.LOST


_MEANINGS: Final[Mapping[str, tuple[MatrixErrorKind, str]]] = {
    "M_UNKNOWN_TOKEN": (
        MatrixErrorKind.SIGNED_OUT,
        "The homeserver does not accept the access token any more.",
    ),
    "M_MISSING_TOKEN": (
        MatrixErrorKind.SIGNED_OUT,
        "The homeserver does not accept the access token any more.",
    ),
    "M_USER_DEACTIVATED": (MatrixErrorKind.UNUSABLE, "This account was deactivated."),
    "M_USER_LOCKED": (MatrixErrorKind.UNUSABLE, "This account is locked."),
    "M_FORBIDDEN": (MatrixErrorKind.FORBIDDEN, "The homeserver does not allow that."),
    "M_GUEST_ACCESS_FORBIDDEN": (MatrixErrorKind.FORBIDDEN, "The homeserver does not allow that."),
    "M_NOT_FOUND": (MatrixErrorKind.NOT_FOUND, "The homeserver knows no such thing."),
    "M_LIMIT_EXCEEDED": (MatrixErrorKind.TOO_FAST, "The homeserver asks to wait."),
    "M_UNKNOWN": (MatrixErrorKind.LOST, "The homeserver could not do it."),
}
"""By Matrix's error codes (https://spec.matrix.org/latest/client-server-api/#standard-error-response)."""


def refusal(status: int, body: object) -> MatrixError:
    """Return what an answer means that is no success. Total: every answer means something.

    Args:
        status: Of HTTP; 0 where it is not known.
        body: The answer's JSON, as it came.
    """
    said = body if isinstance(body, dict) else {}
    errcode, words = _text(said.get("errcode")), _text(said.get("error"))
    kind, sentence = _meaning(status, errcode)
    found = MatrixError(sentence, kind, f"{status} {errcode} {words}".strip(), errcode=errcode)
    if kind is MatrixErrorKind.TOO_FAST:
        found.wait_s = _wait_s(said.get("retry_after_ms"))
    found.soft = said.get("soft_logout") is True
    found.body = said
    return found


def _meaning(status: int, errcode: str) -> tuple[MatrixErrorKind, str]:
    if errcode in _MEANINGS and not (errcode == "M_UNKNOWN" and 400 <= status < 500):  # noqa: PLR2004
        return _MEANINGS[errcode]
    if status == 429:  # noqa: PLR2004
        return _MEANINGS["M_LIMIT_EXCEEDED"]
    if status >= 500 or not status:  # noqa: PLR2004
        return (
            MatrixErrorKind.LOST,
            "The homeserver did not answer. It may or may not have arrived.",
        )
    return MatrixErrorKind.REFUSED, "The homeserver did not take it."


def trouble(error: BaseException) -> RosicError:
    """Return what a foreign exception means; one of ours means itself."""
    if isinstance(error, RosicError):
        return error
    reason = f"{type(error).__name__}: {error}"
    if isinstance(error, OlmTrustError):
        return MatrixError(
            "Somebody in this room has a device that nobody has verified. Nothing was sent.",
            MatrixErrorKind.REFUSED,
            reason,
        )
    if isinstance(error, LocalProtocolError):
        return MatrixError("That cannot be done in this room now.", MatrixErrorKind.REFUSED, reason)
    return MatrixError(
        "The homeserver cannot be reached. It may or may not have arrived.",
        MatrixErrorKind.LOST,
        reason,
    )


def _text(value: object) -> str:
    return value if isinstance(value, str) else ""


def _wait_s(value: object) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and value > 0:
        return value / 1_000
    return DEFAULT_WAIT_S
