"""Signing in with a passkey: the ceremonies of WebAuthn, and who has passed one.

A passkey is made on the page by somebody who has signed in there, and signs in the same person
later without their chat. It is bound to the name of this page, so no other page can ask for it.
"""

from __future__ import annotations

import json
from hashlib import blake2b
from hmac import compare_digest
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import webauthn
from webauthn.helpers import base64url_to_bytes, options_to_json
from webauthn.helpers.exceptions import WebAuthnException
from webauthn.helpers.structs import (
    AuthenticatorSelectionCriteria,
    PublicKeyCredentialDescriptor,
    ResidentKeyRequirement,
    UserVerificationRequirement,
)

from rosic.core.i18n import said
from rosic.core.identity import PrincipalId
from rosic.core.language.sanitise import clean_name
from rosic.core.time_units import MINUTE_NS
from rosic.errors import NotPermitted, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.api.callers import ApiCaller
    from rosic.api.settings import ApiSettings
    from rosic.authoriser.passkeys import Passkey
    from rosic.core.records import Fact
    from rosic.core.secret import Secret
    from rosic.gateway.access_registry import AccessRegistry

CHALLENGE_NS: Final = 2 * MINUTE_NS
KEY_BYTES: Final = 32
NONCE_BYTES, TIME_BYTES, CODE_BYTES = 16, 8, 16
PLAIN_BYTES: Final = NONCE_BYTES + TIME_BYTES
NOBODY: Final = PrincipalId("")
NOT_GOOD: Final = said("That passkey is not good here. Sign in with a code from your chat: /signin")
NO_NAME: Final = said(
    "Passkeys need a name of this page, not a number: say url and hosts in [api]."
)
ONLY_PEOPLE: Final = said("Only a person who has signed in on the page makes passkeys there.")


class PasskeyCeremonies:
    """Offers and checks the ceremonies.

    A challenge says itself until when it is good and for whom, under a code of this process, so
    that nothing is kept for strangers who only ask. Those that were passed are kept till they end:
    each is good once.

    Args:
        access: Knows passkeys and sessions.
        settings: By which name the page is reached.
        place: How this place is called.
        token: Returns so many random bytes.
    """

    def __init__(
        self,
        access: AccessRegistry,
        settings: ApiSettings,
        place: str,
        token: Callable[[int], bytes],
    ) -> None:
        self._access, self._place, self._token = access, place, token
        address = urlsplit(settings.reached_at)
        self._party = address.hostname or ""
        self._origin = f"{address.scheme}://{address.netloc}"
        self._code_key = token(KEY_BYTES)
        self._passed: dict[bytes, int] = {}

    @property
    def possible(self) -> bool:
        """Whether the page has a name that passkeys can be bound to."""
        return (
            bool(self._party)
            and not self._party.replace(".", "").isdigit()
            and (":" not in self._party)
        )

    # ---- making one ----

    def offer(self, caller: ApiCaller) -> dict[str, Any]:
        """Return what a browser needs to make a passkey for somebody who has signed in.

        Raises:
            NotPermitted: It is no person on the page, or the page has no name.
        """
        self._check_possible()
        if not caller.by_cookie:
            raise NotPermitted(ONLY_PEOPLE)
        known = self._access.passkeys.of(caller.principal).values()
        options = webauthn.generate_registration_options(
            rp_id=self._party,
            rp_name=self._place,
            challenge=self._challenge(caller.principal),
            user_id=caller.principal.encode(),
            user_name=caller.name,
            authenticator_selection=AuthenticatorSelectionCriteria(
                resident_key=ResidentKeyRequirement.REQUIRED,
                user_verification=UserVerificationRequirement.REQUIRED,
            ),
            exclude_credentials=[PublicKeyCredentialDescriptor(id=p.credential) for p in known],
        )
        return _read(options_to_json(options))

    def made(self, caller: ApiCaller, credential: dict[str, Any], name: str) -> Fact:
        """Return what makes a credential somebody's passkey.

        Raises:
            Unrecognised: It is none that was asked for. Nothing changed.
            TooManyRequests: They have too many. Nothing changed.
        """
        self._check_possible()
        challenge = self._take(credential, caller.principal)
        try:
            verified = webauthn.verify_registration_response(
                credential=credential,
                expected_challenge=challenge,
                expected_rp_id=self._party,
                expected_origin=self._origin,
                require_user_verification=True,
            )
        except (WebAuthnException, ValueError, TypeError, KeyError) as wrong:
            raise Unrecognised(NOT_GOOD) from wrong
        self._pass(challenge)
        return self._access.passkeys.add(
            caller.principal,
            verified.credential_id,
            verified.credential_public_key,
            verified.sign_count,
            clean_name(name) or self._place,
        )

    # ---- signing in ----

    def ask(self) -> dict[str, Any]:
        """Return what a browser needs to sign in with whichever passkey its owner chooses.

        Raises:
            NotPermitted: The page has no name that passkeys are bound to.
        """
        self._check_possible()
        options = webauthn.generate_authentication_options(
            rp_id=self._party,
            challenge=self._challenge(NOBODY),
            user_verification=UserVerificationRequirement.REQUIRED,
        )
        return _read(options_to_json(options))

    def redeem(self, credential: dict[str, Any]) -> tuple[Secret, tuple[Fact, ...]]:
        """Return the token of a new session of whoever has shown their passkey.

        Raises:
            Unrecognised: It is not good, or its owner has no access any more. It is counted.
        """
        self._check_possible()
        passkeys, counters = self._access.passkeys, self._access.counters
        try:
            challenge = self._take(credential, NOBODY)
            passkey = self._shown(credential)
            verified = webauthn.verify_authentication_response(
                credential=credential,
                expected_challenge=challenge,
                expected_rp_id=self._party,
                expected_origin=self._origin,
                credential_public_key=passkey.public_key,
                credential_current_sign_count=passkey.uses,
                require_user_verification=True,
            )
        except Unrecognised as why:
            raise counters.refuse("passkey", why) from None
        except (WebAuthnException, ValueError, TypeError, KeyError) as wrong:
            raise counters.refuse("passkey", Unrecognised(NOT_GOOD)) from wrong
        self._pass(challenge)
        token, session = self._access.page_sessions.begin(passkey.principal)
        return token, (passkeys.used(passkey, verified.new_sign_count), session)

    def _shown(self, credential: dict[str, Any]) -> Passkey:
        passkeys = self._access.passkeys
        found = passkeys.by_credential(base64url_to_bytes(str(credential.get("id", ""))))
        if found is None:
            raise Unrecognised(NOT_GOOD)
        return found

    # ---- challenges ----

    def _check_possible(self) -> None:
        if not self.possible:
            raise NotPermitted(NO_NAME)

    def _challenge(self, principal: PrincipalId) -> bytes:
        """Return what an authenticator has to sign; for ``NOBODY``: whoever signs in."""
        ends_ns = self._access.time.wall_ns() + CHALLENGE_NS
        plain = self._token(NONCE_BYTES) + ends_ns.to_bytes(TIME_BYTES)
        return plain + self._code(plain, principal)

    def _code(self, plain: bytes, principal: PrincipalId) -> bytes:
        whole = plain + principal.encode()
        return blake2b(whole, key=self._code_key, digest_size=CODE_BYTES).digest()

    def _take(self, credential: dict[str, Any], principal: PrincipalId) -> bytes:
        """Return the challenge that a credential answers.

        Raises:
            Unrecognised: It answers none of ours, or too late, or one that was passed.
        """
        try:
            client = json.loads(base64url_to_bytes(credential["response"]["clientDataJSON"]))
            answered = base64url_to_bytes(client["challenge"])
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as wrong:
            raise Unrecognised(NOT_GOOD) from wrong
        plain, code = answered[:PLAIN_BYTES], answered[PLAIN_BYTES:]
        ours = compare_digest(code, self._code(plain, principal))
        ends_ns = int.from_bytes(plain[NONCE_BYTES:])
        if not ours or answered in self._passed or ends_ns <= self._access.time.wall_ns():
            raise Unrecognised(NOT_GOOD)
        return answered

    def _pass(self, challenge: bytes) -> None:
        """Let a challenge be good no more; those that have ended need not be kept."""
        now_ns = self._access.time.wall_ns()
        self._passed = {one: ends for one, ends in self._passed.items() if ends > now_ns}
        self._passed[challenge] = int.from_bytes(challenge[NONCE_BYTES:PLAIN_BYTES])


def _read(text: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(text)
    return found
