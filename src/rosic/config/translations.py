"""The catalogues that ship with ROSIC: ``rosic/locale/<language>/LC_MESSAGES/rosic.mo``."""

from __future__ import annotations

import logging
from functools import cache
from gettext import GNUTranslations
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.authoriser.authoriser import Authoriser
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import Address, PrincipalId

LANGUAGES: Mapping[str, tuple[str, ...]] = {
    "en": ("English", "englisch"),
    "de": ("Deutsch", "German"),
}
"""What is spoken here: a code, and what people call the language; first, as it calls itself."""

log = logging.getLogger("rosic.languages")


@cache
def catalogue(code: str) -> Catalogue | None:
    """Return the catalogue of a language; None for English, and where it cannot be read."""
    if code == "en":
        return None
    compiled = files("rosic") / "locale" / code / "LC_MESSAGES" / "rosic.mo"
    try:
        with compiled.open("rb") as file:
            return GNUTranslations(file)
    except OSError:
        log.warning("the catalogue of %s cannot be read: sentences stay English", code)
        return None


def of_locale(locale: str) -> Catalogue | None:
    """Return the catalogue that goes with a locale: ``de_AT``; None for English and others."""
    code = locale.partition("_")[0].casefold()
    return catalogue(code) if code in LANGUAGES else None


def whose(authoriser: Authoriser, address: Address) -> PrincipalId | None:
    """Return who is at an address, for speaking to them in their language."""
    found = authoriser.directory.at(address)
    return None if found is None else found[0].id
