"""Who reads which language: chosen per person; a platform's own setting is only the default."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.core.i18n import Catalogue, ImperialCatalogue, in_language
from rosic.core.message import LIES_IN

if TYPE_CHECKING:
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.message import Button, Inbound, Outbound

Load: TypeAlias = Callable[[str], "Catalogue | None"]
"""Code to catalogue; None where there is none, and for English, which needs none."""

HEARD_AT_MOST = 20_000

_Rows: TypeAlias = "tuple[tuple[Button, ...], ...]"


def _english(_code: str) -> None:
    return None


def _plain_code(locale: str) -> str:
    return locale.casefold().replace("_", "-").partition("-")[0]


def _nobody(_address: Address) -> None:
    return None


class ChatLanguages:
    """Everybody's catalogue. Whoever reads English costs one look-up that finds nothing.

    Args:
        load: Reads a catalogue; asked once for each language that somebody wants.
        known: What there is, by code; nothing else is ever asked of ``load``.
        at: Returns who writes from an address; None: nobody known.
    """

    def __init__(
        self,
        load: Load = _english,
        known: Mapping[str, object] | None = None,
        at: Callable[[Address], PrincipalId | None] = _nobody,
    ) -> None:
        self._at = at
        self._load = load
        self._known = known or {}
        self._catalogues: dict[str, Catalogue | None] = {}
        self._chosen: dict[PrincipalId, str] = {}
        self._imperial: set[PrincipalId] = set()
        self._imperials: dict[Catalogue | None, Catalogue] = {}
        self._heard: OrderedDict[PrincipalId, str] = OrderedDict()
        self._suggested: OrderedDict[PrincipalId, str] = OrderedDict()
        self._readers: dict[PrincipalId, Catalogue] = {}

    def of(self, principal: PrincipalId) -> Catalogue | None:
        """Return the catalogue of somebody; None means English."""
        return self._readers.get(principal)

    def of_sender(self, inbound: Inbound) -> Catalogue | None:
        """Return the catalogue of whoever wrote this, known or not."""
        return self.of_reader(inbound.sender, inbound.locale)

    def of_reader(self, address: Address, locale: str) -> Catalogue | None:
        """Return the catalogue of whoever is at an address, known or not.

        Args:
            address: Where they read.
            locale: What their messenger is set to: the default of whoever has not chosen.
        """
        if not locale and not self._readers:
            return None
        principal = self._at(address)
        if principal is None:
            return self.spoken(locale)
        if locale:  # of whoever has come in by this very message, nothing was heard yet
            self.hear(principal, locale)
        return self.of(principal)

    def of_address(self, address: Address) -> Catalogue | None:
        """Return the catalogue of whoever is at an address; English for a stranger."""
        principal = self._at(address) if self._readers else None
        return None if principal is None else self.of(principal)

    def spoken(self, locale: str) -> Catalogue | None:
        """Return the catalogue that goes with a platform's setting: ``de``, ``de-AT``."""
        code = _plain_code(locale)
        if code not in self._known:
            return None
        if code not in self._catalogues:
            self._catalogues[code] = self._load(code)
        return self._catalogues[code]

    def catalogues(self) -> dict[str, Catalogue]:
        """Return every catalogue there is, by its code."""
        found = {code: self.spoken(code) for code in self._known}
        return {code: catalogue for code, catalogue in found.items() if catalogue is not None}

    def choose(self, principal: PrincipalId, code: str, *, imperial: bool = False) -> None:
        """Let somebody's choice of words and units count; an empty code takes it back."""
        if imperial:
            self._imperial.add(principal)
        else:
            self._imperial.discard(principal)
        if code:
            self._chosen[principal] = code
        else:
            self._chosen.pop(principal, None)
        self._settle(principal)

    def chosen(self) -> Mapping[PrincipalId, str]:
        """Return which language people chose, by its code."""
        return self._chosen

    def hear(self, principal: PrincipalId, locale: str) -> None:
        """Note what somebody's messenger is set to: the default of whoever has not chosen."""
        if self._heard.get(principal) == locale:
            return
        self._heard[principal] = locale
        self._settle(principal)
        if len(self._heard) > HEARD_AT_MOST:
            self._settle(self._heard.popitem(last=False)[0])

    def suggest(self, principal: PrincipalId, locale: str) -> None:
        """Note what somebody's browser asks for.

        It counts where no messenger is set to a language that is spoken here besides English,
        which is also what a messenger or a terminal says that nobody has set.
        """
        if not locale or principal in self._suggested:
            return
        self._suggested[principal] = locale
        self._settle(principal)
        if len(self._suggested) > HEARD_AT_MOST:
            self._settle(self._suggested.popitem(last=False)[0])

    def _wanted(self, principal: PrincipalId) -> str:
        """Return what somebody chose, else what a messenger, else what their browser is set to."""
        if chosen := self._chosen.get(principal):
            return chosen
        heard = self._heard.get(principal, "")
        if _plain_code(heard) != "en" and self.spoken(heard) is not None:
            return heard
        return self._suggested.get(principal, heard)

    def code(self, principal: PrincipalId) -> str:
        """Return the code of the language that somebody reads."""
        code = self._wanted(principal)
        return "en" if self.spoken(code) is None else _plain_code(code)

    def _settle(self, principal: PrincipalId) -> None:
        catalogue = self.spoken(self._wanted(principal))
        if principal in self._imperial:
            catalogue = self._imperials.setdefault(catalogue, ImperialCatalogue(catalogue))
        if catalogue is None:
            self._readers.pop(principal, None)
        else:
            self._readers[principal] = catalogue


def translated(outbound: Outbound, catalogue: Catalogue | None) -> Outbound:
    """Return a message as its reader reads it: plain, in their language."""
    text, buttons = in_language(outbound.text, catalogue), outbound.buttons
    if buttons:
        buttons = labelled(buttons, catalogue)
    lies_in = in_language(LIES_IN, catalogue) if outbound.attachment is not None else ""
    return msgspec.structs.replace(outbound, text=text, buttons=buttons, lies_in=lies_in)


def labelled(buttons: _Rows, catalogue: Catalogue | None) -> _Rows:
    """Return buttons with labels as their reader reads them; they say what they said."""
    return tuple(
        tuple(
            msgspec.structs.replace(button, label=in_language(button.label, catalogue))
            for button in row
        )
        for row in buttons
    )
