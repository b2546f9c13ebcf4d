"""Refusals as RFC 9457 problem details: the codes and the sentences of the chat."""

from __future__ import annotations

from http import HTTPStatus
from math import ceil
from typing import TYPE_CHECKING, Final

import msgspec
from litestar import Response

from rosic.api.schemas import Problem
from rosic.core.i18n import plain
from rosic.errors import Refusal, RosicError

if TYPE_CHECKING:
    from collections.abc import Mapping

PROBLEM: Final = "application/problem+json"
ABOUT: Final = "/problems/"

_STATUS: Final[Mapping[str, HTTPStatus]] = {
    "unrecognised": HTTPStatus.UNAUTHORIZED,
    "not-permitted": HTTPStatus.FORBIDDEN,
    "unverified": HTTPStatus.FORBIDDEN,
    "inert": HTTPStatus.FORBIDDEN,
    "not-found": HTTPStatus.NOT_FOUND,
    "nothing-to-see": HTTPStatus.NOT_FOUND,
    "not-understood": HTTPStatus.UNPROCESSABLE_ENTITY,
    "out-of-bounds": HTTPStatus.UNPROCESSABLE_ENTITY,
    "too-many-requests": HTTPStatus.TOO_MANY_REQUESTS,
    "first-needed": HTTPStatus.CONFLICT,
    "take-over": HTTPStatus.CONFLICT,
    "robot-taken": HTTPStatus.CONFLICT,
    "robot-busy": HTTPStatus.CONFLICT,
    "robot-stopped": HTTPStatus.CONFLICT,
    "still-moves": HTTPStatus.CONFLICT,
    "order-void": HTTPStatus.CONFLICT,
    "expired": HTTPStatus.CONFLICT,
    "repeated": HTTPStatus.CONFLICT,
    "robot-offline": HTTPStatus.SERVICE_UNAVAILABLE,
    "time-in-doubt": HTTPStatus.SERVICE_UNAVAILABLE,
    "record-unavailable": HTTPStatus.SERVICE_UNAVAILABLE,
    "messenger-fault": HTTPStatus.SERVICE_UNAVAILABLE,
    "late": HTTPStatus.GATEWAY_TIMEOUT,
}
"""What is not named is what cannot be processed as it stands: 409."""


def status_of(code: str) -> HTTPStatus:
    """Return the status of HTTP that stands for a refusal."""
    return _STATUS.get(code, HTTPStatus.CONFLICT)


def problem_of(error: RosicError, sentence: str) -> Problem:
    """Return how a refusal reads to a program, with its sentence in the program's language."""
    if not isinstance(error, Refusal):
        return problem(error.code, sentence)
    return problem(error.code, sentence, offers=error.offers, retry_after_s=error.retry_after_s)


def problem(
    code: str,
    detail: str,
    *,
    status: int = 0,
    offers: tuple[str, ...] = (),
    retry_after_s: float | None = None,
) -> Problem:
    """Return a problem of a kind.

    Args:
        code: Stable name of the kind.
        detail: One sentence.
        status: Of HTTP, where it is not the usual one of its kind.
        offers: What would be accepted instead.
        retry_after_s: Seconds until trying again may succeed.
    """
    title = code.replace("-", " ").capitalize()
    number = status or int(status_of(code))
    return Problem(
        ABOUT + code, title, number, plain(detail), code, tuple(map(plain, offers)), retry_after_s
    )


def answer(found: Problem) -> Response[bytes]:
    """Return a problem as the answer to a request."""
    headers = {"Cache-Control": "no-store"}
    if found.status == HTTPStatus.UNAUTHORIZED:
        headers["WWW-Authenticate"] = "Bearer"
    if found.retry_after_s:
        headers["Retry-After"] = str(ceil(found.retry_after_s))
    return Response(
        msgspec.json.encode(found),
        status_code=found.status,
        media_type=PROBLEM,
        headers=headers,
    )
