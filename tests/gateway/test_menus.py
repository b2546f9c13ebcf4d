"""The menu of commands in somebody's own chat is in the language that they chose here."""

from __future__ import annotations

from rosic.app.features import command_table
from rosic.config.plugins import catalogue
from rosic.core.language.command import MenuAudience
from rosic.core.message import Menu, MenuScope
from rosic.gateway.command_menus import CommandMenus
from tests.gateway.place import ADA, BO, VI, Place
from tests.gateway.test_rights import who

GERMAN = catalogue("de")
COMMANDS = command_table()
EVERYBODY = COMMANDS.in_menu(MenuAudience.EVERYBODY)
ADMINS = COMMANDS.in_menu(MenuAudience.ADMINS)


def menus_of(place: Place) -> CommandMenus:
    assert GERMAN is not None
    directory = place.gateway.rooms.authoriser.directory
    ada = who(place, "Ada")
    return CommandMenus(
        directory,
        lambda: [ada],
        {"de": GERMAN},
        place.gateway.languages.chosen,
        place.clock,
        COMMANDS,
    )


def own(menus: list[Menu], account: str) -> dict[str, dict[str, str]]:
    """Return the menus of somebody's own chat by language."""
    return {
        m.locale: dict(m.commands) for m in menus if m.where is MenuScope.CHAT and m.chat == account
    }


async def test_whoever_chose_a_language_reads_their_menu_in_it_whatever_telegram_says() -> None:
    async with Place().open() as place:
        menus = menus_of(place)
        assert own(menus.of("memory"), BO) == {}, "theirs is everybody's"
        await place.say("/language de", account=BO, chat=BO)
        german = own(menus.of("memory"), BO)
        assert german[""] == german["de"]
        assert len(german[""]) == len(EVERYBODY)
        assert german[""]["buchen"] == "Einen Roboter für eine Zeit buchen"
        assert "undo" in german[""], "a menu spells no umlaut"
        assert own(menus.of("memory"), VI) == {}


async def test_an_admin_has_all_of_theirs_and_a_choice_taken_back_is_taken_back() -> None:
    async with Place().open() as place:
        menus = menus_of(place)
        await place.say("/language en", account=ADA, chat=ADA)
        english = own(menus.of("memory"), ADA)
        assert english["de"] == english[""] == {c.name: c.summary for c in (*EVERYBODY, *ADMINS)}
        await place.say("/language de", account=BO, chat=BO)
        assert own(menus.of("memory"), BO)
        place.gateway.languages.choose(who(place, "Bo"), "")
        assert own(menus.of("memory"), BO) == {"": {}, "de": {}}, "taken away, once"
        assert own(menus.of("memory"), BO) == {}
