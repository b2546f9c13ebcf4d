"""What does not fit in a request, field by field, as a sentence in everybody's language.

The framework says it in English; what it says has a few forms, and each of them is said anew here.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from rosic.core.i18n import filled, joined, said

if TYPE_CHECKING:
    from collections.abc import Mapping

    from litestar.exceptions import ValidationException
    from litestar.handlers import BaseRouteHandler

    from rosic.core.i18n import Sentence

BODY: Final = "data"
FIELDS_AT_MOST: Final = 4
LETTERS_AT_MOST: Final = 64
NO_BODY: Final = said("the body is missing")
BODY_WRONG: Final = said("the body has to be an object in JSON")
MISSING: Final = said("{field} is missing")
ODD: Final = said("{field} may not be that")

_FORMS: Final[tuple[tuple[re.Pattern[str], Sentence], ...]] = (
    (re.compile(r"missing required field `(?P<field>.*)`"), MISSING),
    (re.compile(r"Missing required \w+ parameter '(?P<field>.*?)'"), MISSING),
    (re.compile(r"unknown field `(?P<field>.*)`"), said("{field} is not known here")),
    (
        re.compile(r"Expected `str` of length >= (?P<n>\S+)"),
        said("{field} has to have at least {n} characters"),
    ),
    (
        re.compile(r"Expected `str` of length <= (?P<n>\S+)"),
        said("{field} may have at most {n} characters"),
    ),
    (re.compile(r"of length >= (?P<n>\S+)"), said("{field} has to have at least {n} entries")),
    (re.compile(r"of length <= (?P<n>\S+)"), said("{field} may have at most {n} entries")),
    (re.compile(r"Expected `\w+` >= (?P<n>\S+)"), said("{field} has to be at least {n}")),
    (re.compile(r"Expected `\w+` <= (?P<n>\S+)"), said("{field} may be at most {n}")),
    (re.compile(r"Expected `float \| str`"), said("{field} has to be a number or text")),
    (re.compile(r"Expected `str`"), said("{field} has to be text")),
    (re.compile(r"Expected `int`"), said("{field} has to be a whole number")),
    (re.compile(r"Expected `float`"), said("{field} has to be a number")),
    (re.compile(r"Expected `bool`"), said("{field} has to be true or false")),
    (re.compile(r"Expected `array`"), said("{field} has to be a list")),
    (re.compile(r"Expected `object`"), said("{field} has to be an object in JSON")),
)


def not_fitting(error: ValidationException, handler: BaseRouteHandler) -> str:
    """Return what is said of a request of which something does not fit.

    Args:
        error: What the framework found.
        handler: For whom the request was; it knows how its parameters are called outside.
    """
    parts = [each for each in error.extra or () if isinstance(each, dict)]
    parts = parts or [{"message": error.detail}]
    found = joined("; ", (_wrong(part, handler) for part in parts[:FIELDS_AT_MOST]))
    return said("That does not fit here: {what}. Nothing was done.", what=found)


def _wrong(part: Mapping[str, Any], handler: BaseRouteHandler) -> str:
    field, message = str(part.get("key", "")), str(part.get("message", ""))
    if field == BODY and message == repr(BODY):
        return NO_BODY
    if field == BODY and message.startswith("Expected"):
        return BODY_WRONG
    for pattern, form in _FORMS:
        if (match := pattern.search(message)) is not None:
            told = {"field": _called(field, handler), **match.groupdict()}
            told = {name: text[:LETTERS_AT_MOST].removesuffix(".0") for name, text in told.items()}
            return filled(form, **told)
    return filled(ODD, field=_called(field, handler)[:LETTERS_AT_MOST])


def _called(field: str, handler: BaseRouteHandler) -> str:
    """Return the name by which whoever asks knows a parameter."""
    parameter = handler.parsed_fn_signature.parameters.get(field)
    named = None if parameter is None else getattr(parameter.kwarg_definition, "name", None)
    return named or field
