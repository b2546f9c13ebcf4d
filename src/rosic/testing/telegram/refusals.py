"""Telegram's refusals, in Telegram's own words.

https://core.telegram.org/bots/api#making-requests: an unsuccessful request has `ok` false, an
`error_code`, a `description`, and sometimes `parameters`
(https://core.telegram.org/bots/api#responseparameters). The documentation lists no descriptions;
the sentences here are those of the published server (https://github.com/tdlib/telegram-bot-api) and
of common experience with the hosted one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject

NOT_MODIFIED = (
    "message is not modified: specified new message content and reply markup are exactly the same "
    "as a current content and reply markup of the message"
)
OTHER_POLLER = (
    "Conflict: terminated by other getUpdates request; "
    "make sure that only one bot instance is running"
)
WEBHOOK_ACTIVE = (
    "Conflict: can't use getUpdates method while webhook is active; "
    "use deleteWebhook to delete the webhook first"
)
WEBHOOK_SET = "Conflict: terminated by setWebhook request"
QUERY_TOO_OLD = "query is too old and response timeout expired or query ID is invalid"


class ApiError(Exception):
    """An answer with `ok` false. Nothing has changed on the server.

    Attributes:
        code: HTTP status and `error_code`.
        description: As sent.
        parameters: `retry_after` or `migrate_to_chat_id`, or nothing.
    """

    def __init__(self, code: int, description: str, parameters: JsonObject | None = None) -> None:
        super().__init__(f"{code} {description}")
        self.code = code
        self.description = description
        self.parameters: JsonObject = parameters or {}


class ControlError(ValueError):
    """A test asked for what no person could do, such as pressing a button that is not there."""


def bad_request(reason: str, parameters: JsonObject | None = None) -> ApiError:
    """Return a 400 with this reason."""
    return ApiError(400, f"Bad Request: {reason}", parameters)


def forbidden(reason: str) -> ApiError:
    """Return a 403 with this reason."""
    return ApiError(403, f"Forbidden: {reason}")


def conflict(description: str) -> ApiError:
    """Return a 409, which tells a poller that it is not alone."""
    return ApiError(409, description)


def too_many(retry_after_s: int) -> ApiError:
    """Return a 429 with `retry_after` in whole seconds."""
    return ApiError(
        429, f"Too Many Requests: retry after {retry_after_s}", {"retry_after": retry_after_s}
    )
