"""``/settings`` and ``/language``: how somebody wants to be served."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.container.preferences import IMPERIAL, METRIC
from rosic.core.i18n import capital, said
from rosic.core.message import Button
from rosic.errors import NotUnderstood
from rosic.features.personal_data import messages as words
from rosic.gateway.commands import Reply, check_private
from rosic.organiser.timezones import known_zones, zone_named

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext

LANGUAGE, UNITS, ROBOT, SPEED, ZONE = "language", "units", "robot", "speed", "zone"
NAMES: Mapping[str, str] = {
    LANGUAGE: LANGUAGE,
    "lang": LANGUAGE,
    UNITS: UNITS,
    "unit": UNITS,
    ROBOT: ROBOT,
    "default": ROBOT,
    SPEED: SPEED,
    "limit": SPEED,
    "cap": SPEED,
    ZONE: ZONE,
    "timezone": ZONE,
    # In German, as the list and its example say it.
    "sprache": LANGUAGE,
    "einheiten": UNITS,
    "roboter": ROBOT,
    "zeitzone": ZONE,
    "tempo": SPEED,
    "höchstgeschwindigkeit": SPEED,
    "geschwindigkeit": SPEED,
    "grenze": SPEED,
}


class SettingsCommands:
    """The handler of settings."""

    def __init__(self, data_context: ContainerContext) -> None:
        self._data_context = data_context
        self._book = data_context.preferences

    async def settings(self, asked: CommandContext) -> Reply:
        """Show everything, or set one thing.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        what, _, value = asked.rest.strip().partition(" ")
        if not what:
            check_private(asked)
            return self._show(asked.caller.principal)
        wanted, value = NAMES.get(what.casefold()), value.strip()
        if what.casefold() == "time" and value.casefold().startswith(ZONE):
            wanted, value = ZONE, value[len(ZONE) :].strip()
        if wanted is None:
            raise NotUnderstood(words.no_such_setting(what), offers=("/settings",))
        if wanted == LANGUAGE and not value:
            return self._languages(asked.caller.principal)
        return await self._set(asked.caller.principal, wanted, value)

    async def language(self, asked: CommandContext) -> Reply:
        """Set the language, or offer those there are.

        Raises:
            Refusal: Not spoken here; nothing was changed.
        """
        typed = asked.rest.strip()
        if typed:
            return await self._set(asked.caller.principal, LANGUAGE, typed)
        return self._languages(asked.caller.principal)

    def _languages(self, principal: PrincipalId) -> Reply:
        """Say which language somebody reads, and offer those there are."""
        languages = self._book.languages
        row = tuple(Button(names[0], f"/language {code}") for code, names in languages.items())
        names = [names[0] for names in languages.values()]
        return Reply(words.language(self._language(principal), names), (row,))

    def _language(self, principal: PrincipalId) -> str:
        """Return the language that somebody chose; else whichever they read this in."""
        names = self._book.languages.get(self._book.of(principal).language)
        return words.THIS_LANGUAGE if names is None else names[0]

    async def _set(self, principal: PrincipalId, what: str, value: str) -> Reply:
        async with self._data_context.changes.turn() as turn:
            facts = self._decide(principal, what, value)
            await turn.write(facts)
        kept = self._book.of(principal)
        if what == SPEED and kept.speed:
            limits = self._book.limits(principal)
            robots = dict.fromkeys(limit.partition(":")[0] for limit in limits)
            seen = self._data_context.visible(principal)
            shown = [self._data_context.shown(robot) for robot in robots if robot in seen]
            return Reply(words.speed_set(kept.speed, shown or [said("robots you get later")]))
        return Reply(words.SAVED)

    def _decide(self, principal: PrincipalId, what: str, value: str) -> tuple[Fact, ...]:
        book = self._book
        if what == LANGUAGE:
            return book.set_language(principal, value)
        if what == UNITS:
            return book.set_units(principal, value)
        if what == ROBOT:
            return book.set_robot(principal, value, self._data_context.choices(principal))
        if what == SPEED:
            return book.set_speed(principal, value)
        return book.set_zone(principal, value, _zone)

    def _show(self, principal: PrincipalId) -> Reply:
        kept, languages = self._book.of(principal), self._book.languages
        robot = self._data_context.shown(kept.robot) if kept.robot else ""
        zone = self._data_context.zone_of(principal).name
        text = words.settings(kept, self._language(principal), robot, zone)
        other = METRIC if kept.units == IMPERIAL else IMPERIAL
        row = [Button(capital(words.UNITS_SAID[other]), f"/settings {UNITS} {other}")]
        row += [
            Button(names[0], f"/{LANGUAGE} {code}")
            for code, names in languages.items()
            if code != kept.language  # not chosen, it is that of the messenger: all are offered
        ]
        return Reply(text, (tuple(row),))


def _zone(typed: str) -> str:
    """Return the proper name of a zone; small letters will do.

    Raises:
        OutOfBounds: There is none; says which may have been meant.
    """
    wanted = typed.replace(" ", "_").casefold()
    exact = next((zone for zone in known_zones() if zone.casefold() == wanted), typed)
    return zone_named(exact).name
