"""From a method's name to its answer."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, NamedTuple

from rosic.testing.telegram.methods import bot, chats, media, messages
from rosic.testing.telegram.methods.call import ApiResult, Call, Method
from rosic.testing.telegram.parameters import CallParameters, Raw, check
from rosic.testing.telegram.refusals import ApiError

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram.state import JsonObject
    from rosic.testing.telegram.world import World

METHODS: dict[str, Method] = {
    **bot.METHODS,
    **messages.METHODS,
    **media.METHODS,
    **chats.METHODS,
}
BY_LOWER = {name.lower(): name for name in METHODS}
"""Method names are case-insensitive (https://core.telegram.org/bots/api#making-requests)."""


class Prepared(NamedTuple):
    """A call whose method and parameters are known."""

    method: Method
    call: Call


def prepare(world: World, name: str, raw: Raw, alive: Callable[[], bool]) -> Prepared:
    """Find the method and check the parameters; what no correct client sends is written down.

    Raises:
        ApiError: 404 for an unknown method, 400 for parameters that cannot be parsed.
    """
    known = BY_LOWER.get(name.lower())
    if known is None:
        world.journal.violation(name, "unknown method, or one that this server lacks")
        raise ApiError(404, "Not Found: method not found")
    args, problems = check(METHODS[known].signature, raw)
    for problem in problems:
        world.journal.violation(known, problem)
    return Prepared(METHODS[known], Call(known, args, alive))


async def perform(world: World, prepared: Prepared) -> JsonObject:
    """Carry out the call.

    Returns:
        The answer with `ok` true.

    Raises:
        ApiError: Telegram would refuse.
    """
    if world.state.logged_out:
        raise ApiError(400, "Logged out")
    result = prepared.method.run(world, prepared.call)
    if inspect.isawaitable(result):
        result = await result
    if isinstance(result, ApiResult):
        return {"ok": True, "result": result.result, "description": result.description}
    return {"ok": True, "result": result}


def refused(error: ApiError) -> JsonObject:
    """Return the answer with `ok` false (https://core.telegram.org/bots/api#making-requests)."""
    shown: JsonObject = {
        "ok": False,
        "error_code": error.code,
        "description": error.description,
    }
    if error.parameters:
        shown["parameters"] = error.parameters
    return shown


def recorded(raw: Raw) -> JsonObject:
    """Return what the record keeps of a call that could not be read."""
    return CallParameters(dict(raw.values), raw.files).shown()
