"""The routes of passkeys: make one, sign in with one, see and remove one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec
from litestar import Response, delete, get, post
from litestar.di import NamedDependency
from litestar.params import FromPath, JSONBody, SkipValidation
from litestar.status_codes import HTTP_200_OK, HTTP_201_CREATED, HTTP_204_NO_CONTENT

from rosic.api.passkeys import PasskeyCeremonies
from rosic.api.routes import OPEN, Api, Who, signed_in
from rosic.api.schemas import IdentityOut, moment
from rosic.core.i18n import said
from rosic.errors import NotFound

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext

Ceremonies = NamedDependency[SkipValidation[PasskeyCeremonies]]
NONE: str = said("You have no such passkey.")


class PasskeyOut(msgspec.Struct, frozen=True):
    """A passkey of one's own."""

    id: str
    name: str
    made: str


class CredentialIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a browser returns from a ceremony, as `PublicKeyCredential.toJSON` writes it.

    Attributes:
        name: How its owner calls it; only where one is made.
    """

    credential: dict[str, Any]
    name: str = ""


@post(
    "/passkeys/options",
    status_code=HTTP_200_OK,
    summary="Make a passkey: what it takes",
    tags=["sessions"],
)
async def make_options(ceremonies: Ceremonies, caller: Who) -> dict[str, Any]:
    """Return the options of ``navigator.credentials.create``."""
    return ceremonies.offer(caller)


@post(
    "/passkeys",
    status_code=HTTP_201_CREATED,
    summary="Make a passkey",
    tags=["sessions"],
)
async def make(
    api: Api, ceremonies: Ceremonies, caller: Who, data: JSONBody[CredentialIn]
) -> PasskeyOut:
    """Keep a passkey that the caller's browser has just made."""
    fact = ceremonies.made(caller, data.credential, data.name)
    await api.write((fact,))
    found = api.kernel.access.passkeys
    return PasskeyOut(
        fact.key, found.name(fact.key), moment(found.of(caller.principal)[fact.key].made_ns)
    )


@get("/passkeys", summary="My passkeys", tags=["sessions"])
async def passkeys(api: Api, caller: Who) -> list[PasskeyOut]:
    """Return the caller's passkeys."""
    return list(_own(api, caller).values())


def _own(api: ApiContext, caller: ApiCaller) -> dict[str, PasskeyOut]:
    known = api.kernel.access.passkeys
    return {
        key: PasskeyOut(key, known.name(key), moment(each.made_ns))
        for key, each in known.of(caller.principal).items()
    }


@delete(
    "/passkeys/{passkey:str}",
    status_code=HTTP_204_NO_CONTENT,
    summary="Remove a passkey",
    tags=["sessions"],
)
async def remove(api: Api, caller: Who, passkey: FromPath[str]) -> None:
    """End one of the caller's passkeys, at once."""
    ended = api.kernel.access.passkeys.remove(caller.principal, passkey)
    if not ended:
        raise NotFound(NONE)
    await api.kernel.changes.take_away(ended)


@post(
    "/sessions/passkey/options",
    status_code=HTTP_200_OK,
    summary="Sign in with a passkey: what it takes",
    tags=["sessions"],
    opt={OPEN: True},
)
async def sign_in_options(ceremonies: Ceremonies) -> dict[str, Any]:
    """Return the options of ``navigator.credentials.get``."""
    return ceremonies.ask()


@post(
    "/sessions/passkey",
    status_code=HTTP_201_CREATED,
    summary="Sign in with a passkey",
    tags=["sessions"],
    opt={OPEN: True},
)
async def sign_in(
    api: Api, ceremonies: Ceremonies, data: JSONBody[CredentialIn]
) -> Response[IdentityOut]:
    """Begin a session of whoever has shown their passkey."""
    token, facts = ceremonies.redeem(data.credential)
    await api.begin_session(*facts)
    return signed_in(api, token)


ROUTES = (make_options, make, passkeys, remove, sign_in_options, sign_in)
