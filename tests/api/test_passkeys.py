"""Passkeys: made by whoever has signed in, good for them alone, once, and on this page alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from rosic.api.settings import ApiSettings, HostPort
from rosic.core.records import Fact
from tests.api.authenticator import PRESENT, Authenticator
from tests.api.served import ServedGateway, problem, served

if TYPE_CHECKING:
    from collections.abc import Callable

    import httpx

URL = "http://localhost:8765"
NAMED = ApiSettings(listen=HostPort("127.0.0.1", 0), url=URL)
NOT_GOOD = (
    401,
    "unrecognised",
    "That passkey is not good here. Sign in with a code from your chat: /signin",
)


async def made(place: ServedGateway, name: str = "Ada") -> tuple[httpx.AsyncClient, Authenticator]:
    """Return the browser of a person who has made a passkey, and what holds it."""
    browser, authenticator = await place.person(name), Authenticator(URL)
    options = (await browser.post("/v1/passkeys/options")).json()
    body = {"credential": authenticator.create(options), "name": "Phone"}
    answer = await browser.post("/v1/passkeys", json=body)
    assert answer.status_code == 201, answer.text
    assert answer.json()["name"] == "Phone"
    return browser, authenticator


async def sign_in(place: ServedGateway, authenticator: Authenticator) -> httpx.Response:
    browser = place.client({"Origin": place.url})
    options = (await browser.post("/v1/sessions/passkey/options")).json()
    return await browser.post(
        "/v1/sessions/passkey", json={"credential": authenticator.get(options)}
    )


async def test_whoever_has_made_one_signs_in_without_their_chat_again_and_again() -> None:
    async with served(NAMED) as place:
        browser, authenticator = await made(place)
        for _ in range(2):
            answer = await sign_in(place, authenticator)
            assert (answer.status_code, answer.json()["name"]) == (201, "Ada")
            assert "HttpOnly" in answer.headers["set-cookie"]
        [own] = (await browser.get("/v1/passkeys")).json()
        assert own["name"] == "Phone"


async def test_one_that_is_removed_lets_nobody_in() -> None:
    async with served(NAMED) as place:
        browser, authenticator = await made(place)
        [own] = (await browser.get("/v1/passkeys")).json()
        bo = await place.person("Bo")
        assert problem(await bo.delete(f"/v1/passkeys/{own['id']}"))[0] == 404
        assert (await sign_in(place, authenticator)).status_code == 201
        assert (await browser.delete(f"/v1/passkeys/{own['id']}")).status_code == 204
        assert problem(await sign_in(place, authenticator)) == NOT_GOOD


async def test_whoever_has_no_access_any_more_has_none_by_their_passkey() -> None:
    async with served(NAMED) as place:
        _, authenticator = await made(place, "Bo")
        directory = place.gateway.rooms.authoriser.directory
        key = directory.key_of(place.principal("Bo"))
        assert key is not None
        await place.gateway.access.changes.take_away(
            place.gateway.access.keys.revoke(key.id, place.principal("Ada")).records
        )
        assert (await sign_in(place, authenticator)).status_code == 401


def of_another_page(authenticator: Authenticator) -> None:
    authenticator.origin = "http://localhost.example:8765"


def of_another_party(authenticator: Authenticator) -> None:
    authenticator.party = "example.org"


def unverified(authenticator: Authenticator) -> None:
    authenticator.flags = PRESENT


def counted_back(authenticator: Authenticator) -> None:
    authenticator.uses = -1


def with_another_key(authenticator: Authenticator) -> None:
    authenticator._key = Authenticator(URL)._key


def with_another_id(authenticator: Authenticator) -> None:
    authenticator.id = b"x" * 16


@pytest.mark.parametrize(
    "spoil",
    [
        of_another_page,
        of_another_party,
        unverified,
        counted_back,
        with_another_key,
        with_another_id,
    ],
)
async def test_what_does_not_prove_it_lets_nobody_in(
    spoil: Callable[[Authenticator], None],
) -> None:
    async with served(NAMED) as place:
        _, authenticator = await made(place)
        assert (await sign_in(place, authenticator)).status_code == 201
        spoil(authenticator)
        assert problem(await sign_in(place, authenticator)) == NOT_GOOD


async def test_a_challenge_is_answered_once_and_by_whom_it_was_given_to() -> None:
    async with served(NAMED) as place:
        _, authenticator = await made(place)
        browser = place.client({"Origin": place.url})
        options = (await browser.post("/v1/sessions/passkey/options")).json()
        body = {"credential": authenticator.get(options)}
        assert (await browser.post("/v1/sessions/passkey", json=body)).status_code == 201
        other = place.client({"Origin": place.url})
        assert problem(await other.post("/v1/sessions/passkey", json=body)) == NOT_GOOD
        ada, bo = await place.person("Ada"), await place.person("Bo")
        asked = (await ada.post("/v1/passkeys/options")).json()
        stolen = {"credential": Authenticator(URL).create(asked)}
        assert problem(await bo.post("/v1/passkeys", json=stolen)) == NOT_GOOD


@pytest.mark.parametrize(
    "credential",
    [{}, {"id": 7}, {"response": {}}, {"response": {"clientDataJSON": "!!"}}, {"response": 7}],
)
async def test_what_is_no_credential_is_refused_in_a_sentence(credential: dict[str, Any]) -> None:
    async with served(NAMED) as place:
        ada = await place.person("Ada")
        for path in ("/v1/passkeys", "/v1/sessions/passkey"):
            assert problem(await ada.post(path, json={"credential": credential})) == NOT_GOOD


async def test_a_program_makes_none_and_neither_does_a_page_without_a_name() -> None:
    async with served(NAMED) as place:
        hal = await place.program("operator")
        assert problem(await hal.post("/v1/passkeys/options"))[:2] == (403, "not-permitted")
    async with served() as place:
        ada = await place.person("Ada")
        refused = problem(await ada.post("/v1/passkeys/options"))
        assert refused[2].startswith("Passkeys need a name of this page, not a number")


async def test_passkeys_outlive_a_restart_and_end_with_whoever_is_erased() -> None:
    async with served(NAMED) as place:
        _, authenticator = await made(place)
        passkeys = place.gateway.access.passkeys
        [key] = passkeys.of(place.principal("Ada"))
        known = passkeys.by_credential(authenticator.id)
        assert known is not None
        again = passkeys.used(known, known.uses)
        passkeys.apply(Fact(kind=again.kind, key=key, body=again.body, letter=again.letter))
        assert passkeys.name(key) == "Phone"
        ended = tuple(passkeys.end_all(place.principal("Ada")))
        await place.gateway.access.changes.take_away(ended)
        assert problem(await sign_in(place, authenticator)) == NOT_GOOD


async def test_strangers_who_only_ask_void_nobodys_challenge() -> None:
    async with served(NAMED) as place:
        _, authenticator = await made(place)
        browser = place.client({"Origin": place.url})
        options = (await browser.post("/v1/sessions/passkey/options")).json()
        stranger = place.client({"Origin": place.url})
        for _ in range(1_100):  # more than were ever kept for everybody together
            await stranger.post("/v1/sessions/passkey/options")
        body = {"credential": authenticator.get(options)}
        assert (await browser.post("/v1/sessions/passkey", json=body)).status_code == 201
        assert (await browser.post("/v1/sessions/passkey", json=body)).status_code == 401
