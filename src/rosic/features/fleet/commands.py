"""The commands about tasks, missions and many robots, as they are declared."""

from __future__ import annotations

from typing import Final

from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpNeed, HelpPage, MenuEntry

COMMANDS: Final = (
    Command(
        name="fleet",
        aliases=("flotte",),
        typed=said("/fleet"),
        summary=said("See all robots and tasks at a glance"),
        help=HelpEntry(HelpPage.FLEET, 10),
        menu=MenuEntry(100),
    ),
    Command(
        name="task",
        cancelled_by="task",
        aliases=("aufgabe",),
        typed=said("/task"),
        summary=said("Let whichever robot can do something"),
        explained=True,
        help=HelpEntry(HelpPage.FLEET, 30, "assign"),
        menu=MenuEntry(90),
    ),
    Command(
        name="tasks",
        cancelled_by="task",
        aliases=("aufgaben",),
        typed=said("/tasks"),
        summary=said("What is being worked on, and what waits"),
        explained=True,
        help=HelpEntry(HelpPage.FLEET, 40, "assign"),
    ),
    Command(
        name="mission",
        verbs={
            "starten": "start",
            "pausieren": "pause",
            "beenden": "cancel",
            "weiter": "go",
            "aus": "off",
            "neu": "new",
            "dazu": "add",
            "zurück": "undo",
            "speichern": "save",
            "teilen": "share",
            "lassen": "leave",
            "vergessen": "forget",
        },
        cancelled_by="mission",
        aliases=("auftrag",),
        typed=said("/mission"),
        summary=said("Several tasks, one after another, also every week"),
        explained=True,
        help=HelpEntry(HelpPage.FLEET, 50, "assign"),
    ),
    Command(
        name="missions",
        summary="which missions there are",
        cancelled_by="mission",
        aliases=("aufträge", "missionen"),
        explained=True,
    ),
    Command(
        name="robot",
        verbs={
            "deaktivieren": "disable",
            "aktivieren": "enable",
            "ausmustern": "retire",
            "aufnehmen": "add",
            "hinzufügen": "add",
        },
        typed=said("/robot"),
        summary="add, disable or take a robot out of service",
    ),
    Command(
        name="together",
        aliases=("gemeinsam",),
        typed=said("/together"),
        summary=said("Let several robots begin at the same moment"),
        explained=True,
        help=HelpEntry(HelpPage.FLEET, 20, HelpNeed.TOGETHER),
    ),
    Command(
        name="broadcast",
        summary="say the same to many robots",
        aliases=("rundruf",),
        explained=True,
    ),
    Command(name="pause", summary="hold one's tasks", aliases=("pausieren",)),
    Command(
        name="continue",
        summary="let them go on",
        aliases=(
            "weiter",
            "fortsetzen",
            "weitermachen",
        ),
        page=HelpPage.MOVE,
    ),
    Command(
        name="handover",
        aliases=("übergeben",),
        typed=said("/handover"),
        summary=said("Pass a robot on to somebody"),
        help=HelpEntry(HelpPage.SHARE, 60, HelpNeed.BOOKING),
    ),
)
