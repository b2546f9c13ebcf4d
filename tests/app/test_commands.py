"""The one table of commands says what ten lists said before there was one."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING, TypeGuard

import pytest

from rosic.app.features import command_table
from rosic.core.language.command import (
    GRAMMAR,
    VERBS,
    Command,
    CommandTable,
    HelpEntry,
    HelpPage,
    MenuAudience,
    MenuEntry,
)
from rosic.core.language.line_parser import _VERBS
from rosic.gateway.commands import CommandContext, CommandRegistry, Reply
from tests import commands
from tests.features.personal_data.data_gateway import a_ward
from tests.shape.tree import source

if TYPE_CHECKING:
    from collections.abc import Iterator

TABLE = command_table()
WORDS = [
    "abort",
    "again",
    "alerts",
    "approve",
    "archive",
    "ask",
    "assist",
    "authenticator",
    "benchmark",
    "book",
    "broadcast",
    "cancel",
    "card",
    "channel",
    "chart",
    "clip",
    "code",
    "continue",
    "data",
    "decline",
    "end",
    "files",
    "fleet",
    "forget",
    "grant",
    "handover",
    "history",
    "information",
    "invite",
    "language",
    "lock",
    "map",
    "me",
    "mission",
    "missions",
    "mute",
    "mydata",
    "path",
    "pause",
    "people",
    "picture",
    "plan",
    "quiet",
    "revoke",
    "robot",
    "role",
    "security",
    "seen",
    "settings",
    "share",
    "shared",
    "shelf",
    "slots",
    "strategy",
    "take",
    "task",
    "tasks",
    "together",
    "topic",
    "trajectory",
    "undo",
    "unlock",
    "unmute",
    "wait",
    "wish",
]
ALIASES = [
    "abbrechen=cancel",
    "ablage=shelf",
    "ablehnen=decline",
    "alarme=alerts",
    "aufgabe=task",
    "aufgaben=tasks",
    "auftrag=mission",
    "aufträge=missions",
    "bild=picture",
    "bitten=ask",
    "buchen=book",
    "dateien=files",
    "daten=mydata",
    "einladen=invite",
    "einstellungen=settings",
    "entsperren=unlock",
    "entziehen=revoke",
    "erlauben=approve",
    "flotte=fleet",
    "fortsetzen=continue",
    "freigeben=resume",
    "geben=grant",
    "gemeinsam=together",
    "helfen=assist",
    "hilfe=help",
    "ich=me",
    "karte=map",
    "leute=people",
    "missionen=missions",
    "nimm=use",
    "nochmal=again",
    "pausieren=pause",
    "planen=plan",
    "protokoll=history",
    "roboter=robots",
    "rolle=role",
    "rundruf=broadcast",
    "rückgängig=undo",
    "sicherheit=security",
    "sperren=lock",
    "sprache=language",
    "strategie=strategy",
    "stumm=mute",
    "tafel=card",
    "teilen=share",
    "verlauf=chart",
    "warten=wait",
    "weg=trajectory",
    "weiter=continue",
    "weitermachen=continue",
    "wunsch=wish",
    "zeiten=slots",
    "zurücknehmen=undo",
    "zustand=status",
    "übergeben=handover",
]
EXPLAINED = [
    "ask",
    "assist",
    "book",
    "broadcast",
    "grant",
    "invite",
    "me",
    "mission",
    "missions",
    "mute",
    "people",
    "quiet",
    "role",
    "settings",
    "share",
    "shelf",
    "strategy",
    "task",
    "tasks",
    "together",
    "wish",
]
PAGES = {
    "move": "again cancel continue resume undo",
    "see": "card chart clip history map picture status trajectory",
    "share": "files handover lock mydata plan revoke security slots wait",
    "fleet": "fleet",
    "alarms": "alerts",
}
EVERYBODY = "robots status use undo stop cancel resume again task fleet book wish ask me help"
ADMINS = "people invite role grant revoke lock plan security"
SECRET = {"authenticator": "reset", "code": "", "join": "", "start": ""}
ON_PAGES = {
    "move": "again use undo stop cancel resume",
    "see": "robots status card history picture map trajectory chart",
    "share": "slots book wish wait cancel_booking handover me ask settings files mydata role grant "
    "invite people revoke security lock plan",
    "fleet": "fleet together task tasks mission",
    "alarms": "alerts mute",
}


def test_the_words_are_those_that_they_were() -> None:
    assert TABLE.words >= set(WORDS)
    assert {f"{word}={name}" for word, name in TABLE.aliases.items()} >= set(ALIASES)
    pairs = {("noch", "einmal"): "again", ("request", "information"): "information"}
    assert TABLE.pairs.items() >= pairs.items()
    assert TABLE.secret.items() >= SECRET.items()
    assert frozenset({"help", "resume", "robots", "start", "status", "use"}) == VERBS


def in_order(found: list[Command], were: str) -> bool:
    """Whether what was there is there in its order, whatever came between."""
    names = [command.name.replace(" ", "_") for command in found]
    return [name for name in names if name in were.split()] == were.split()


def test_help_and_menus_are_those_that_they_were() -> None:
    assert {c.name for c in TABLE if c.explained} >= set(EXPLAINED)
    for page, names in PAGES.items():
        leads = {c.name for c in TABLE if (c.page or (c.help and c.help.page)) == page}
        assert leads.issuperset(names.split())
    for page, listed in ON_PAGES.items():
        assert in_order(TABLE.on_page(HelpPage(page)), listed)
    everybody = TABLE.in_menu(MenuAudience.EVERYBODY)
    assert in_order(everybody, EVERYBODY)
    assert in_order(TABLE.in_menu(MenuAudience.ADMINS), ADMINS)
    groups = [command for command in everybody if command.menu and command.menu.groups]
    assert in_order(groups, "robots status use stop cancel resume help")


def test_whatever_stands_in_help_or_a_menu_says_what_it_is_for() -> None:
    assert [c.name for c in TABLE if (c.help or c.menu) and not c.summary] == []
    assert [c.name for c in TABLE if c.help and not c.typed] == []


@pytest.mark.parametrize(
    "second",
    [
        Command(name="weigh"),
        Command(name="lift", aliases=("weigh",)),
        Command(name="lift", aliases=("hilfe",)),
        Command(name="lift", help=HelpEntry(HelpPage.SEE, 10)),
        Command(name="lift", menu=MenuEntry(10)),
    ],
)
def test_two_commands_share_no_word_and_no_place(second: Command) -> None:
    with pytest.raises(ValueError, match=f"the command {second.name} takes the place of another"):
        CommandTable((Command(name="weigh"), second))


def test_the_page_has_a_line_for_each_that_may_be_said() -> None:
    """Else: make texts."""
    page = commands.PAGE.read_text(encoding="utf-8")
    assert commands.written(page) == page
    assert all(f"\n| `/{word}` |" in page for word in WORDS)


# ---- who does them ----


async def test_somebody_does_every_command_that_is_declared() -> None:
    async with a_ward() as ward:
        assert ward.gateway.pipeline.hooks.commands.undone == frozenset()


def test_nobody_does_what_is_not_declared() -> None:
    registry = CommandRegistry(CommandTable((Command(name="weigh"),)))
    assert registry.undone == {"weigh"}
    registry.register("weigh", never)
    assert registry.undone == frozenset()
    with pytest.raises(ValueError, match="the command lift is not declared"):
        registry.register("lift", never)


async def never(_: CommandContext) -> Reply:
    raise AssertionError("nobody asks this")


# ---- nothing else lists them ----

FEW = 4
"""So many of them in one literal are a list of commands."""
NOT_OF_CHATS = {
    "rosic.app.setup.profile_draft",  # the keys of a profile
    "rosic.bench.command",  # benches of the program
    "rosic.cli.main",  # subcommands of the program
    "rosic.core.language.command",  # declares those of the grammar
    "rosic.core.language.line_parser",  # reads those of the grammar
    "rosic.core.policy.scope",  # rights about the place
    "rosic.features.fleet.mission_builder",  # what follows /mission
}
NAMES = frozenset(c.name for c in TABLE) | frozenset(c.name for c in GRAMMAR)


def test_what_the_grammar_reads_is_what_it_declares() -> None:
    assert _VERBS.keys() == VERBS


def listed(text: str) -> Iterator[int]:
    """Yield the line of each literal in which commands are listed; slots are attributes."""
    tree = ast.parse(text)
    slots = {id(node.value) for node in ast.walk(tree) if is_slots(node)}
    for node in ast.walk(tree):
        if id(node) in slots:
            continue
        if isinstance(node, ast.Tuple | ast.List | ast.Set):
            parts: list[ast.expr | None] = [first(part) for part in node.elts]
        elif isinstance(node, ast.Dict):
            parts = list(node.keys)
        else:
            continue
        words = {p.value for p in parts if isinstance(p, ast.Constant) and p.value in NAMES}
        if len(words) >= FEW:
            yield node.lineno


def is_slots(node: ast.AST) -> TypeGuard[ast.Assign]:
    """Whether it says which attributes a class has."""
    return isinstance(node, ast.Assign) and any(
        isinstance(target, ast.Name) and target.id == "__slots__" for target in node.targets
    )


def first(part: ast.expr) -> ast.expr:
    return part.elts[0] if isinstance(part, ast.Tuple) and part.elts else part


def test_nothing_else_lists_commands() -> None:
    found = [
        f"{module}:{line}"
        for module, text in source().items()
        if module not in NOT_OF_CHATS and module.startswith("rosic.") and "testing" not in module
        for line in listed(text)
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        'SECRET = {"book", "wish", "wait", "slots"}',
        'SAID = {"book": 1, "wish": 2, "wait": 3, "slots": 4}',
        'MENU = (("book", "a"), ("wish", "b"), ("wait", "c"), ("slots", "d"))',
    ],
)
def test_a_list_of_them_would_be_found(text: str) -> None:
    assert list(listed(text)) == [1]
