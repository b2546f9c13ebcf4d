"""Who asks: a program by its key, a person by the session of their browser."""

from __future__ import annotations

from http.cookies import CookieError, SimpleCookie
from operator import itemgetter
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import in_language, said
from rosic.core.secret import Secret
from rosic.errors import Unrecognised

if TYPE_CHECKING:
    from rosic.authoriser.page_sessions import PageSessions
    from rosic.contracts.programs import Programs
    from rosic.core.identity import Address, PrincipalId
    from rosic.gateway.delivery.translation import ChatLanguages

COOKIE: Final = "rosic-session"
SECURE_COOKIE: Final = f"__Host-{COOKIE}"
HEADER_MOST: Final = 4_096
ACCEPTED_MOST: Final = 256
ENGLISH: Final = "en"
NO_KEY: Final = said("Show a key (Authorization: Bearer rosic_...), or sign in on the page.")


class ApiCaller(NamedTuple):
    """Whoever asks.

    Attributes:
        address: From which they speak to the pipeline.
        secret: What they have shown; asked again while a connection is open.
        by_cookie: A browser showed it by itself, so it has to be known which page asks.
    """

    address: Address
    principal: PrincipalId
    name: str
    secret: Secret
    by_cookie: bool


class CallerDirectory:
    """Recognises whoever shows a key or a session.

    Args:
        programs: Knows keys, and who holds them.
        sessions: Knows the sessions of browsers.
        languages: In which somebody is told things.
        secure: Whether browsers reach us by https alone.
    """

    def __init__(
        self,
        programs: Programs,
        sessions: PageSessions,
        languages: ChatLanguages,
        *,
        secure: bool,
    ) -> None:
        self._programs, self._sessions, self._languages = programs, sessions, languages
        self.cookie = SECURE_COOKIE if secure else COOKIE

    def identify(self, shown: str, cookies: str, ticket: str = "") -> ApiCaller:
        """Return who shows this.

        Args:
            shown: The header of the key; empty where there is none.
            cookies: The header; empty where there is none.
            ticket: A key that was given in another way.

        Raises:
            Unrecognised: Nobody is known by it. Nothing changed.
        """
        secret, by_cookie = _bearer(shown) or ticket, False
        if not secret:
            secret, by_cookie = _cookie(cookies, self.cookie), True
        if not secret:
            raise Unrecognised(NO_KEY)
        return self.known_by(Secret(secret), by_cookie=by_cookie)

    def known_by(self, secret: Secret, *, by_cookie: bool) -> ApiCaller:
        """Return who shows a secret now.

        Raises:
            Unrecognised: Nobody is known by it, or not any more.
        """
        who = self._sessions.identify if by_cookie else self._programs.identify
        address = who(secret)
        principal, name = self._programs.who(address)
        return ApiCaller(address, principal, name, secret, by_cookie)

    def read_by(self, sentence: str, caller: ApiCaller | None) -> str:
        """Return a sentence in the language of whoever is told it."""
        catalogue = None if caller is None else self._languages.of(caller.principal)
        return in_language(sentence, catalogue)

    def read_by_stranger(self, sentence: str, accepted: str) -> str:
        """Return a sentence in the language that an ``Accept-Language`` wants most of those here.

        Args:
            sentence: In English.
            accepted: The header; empty where there is none. One that cannot be read wants English.
        """
        for code in _accepted(accepted):
            catalogue = self._languages.spoken(code)
            if catalogue is not None or code.casefold().startswith(ENGLISH):
                return in_language(sentence, catalogue)
        return in_language(sentence, None)


def _accepted(header: str) -> list[str]:
    """Return the languages of an ``Accept-Language``, the most wanted first."""
    wanted: list[tuple[float, str]] = []
    for part in header[:ACCEPTED_MOST].split(","):
        code, _, weight = part.replace(" ", "").partition(";q=")
        try:
            wanted.append((-float(weight or 1), code))
        except ValueError:
            continue
    return [code for weight, code in sorted(wanted, key=itemgetter(0)) if weight < 0]


def _bearer(header: str) -> str:
    kind, _, text = header[:HEADER_MOST].partition(" ")
    return text.strip() if kind.lower() == "bearer" else ""


def _cookie(header: str, name: str) -> str:
    try:
        found = SimpleCookie(header[:HEADER_MOST]).get(name)
    except CookieError:
        return ""
    return "" if found is None else found.value
