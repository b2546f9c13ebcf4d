"""The words that belong to the language itself, so that no robot and no skill may have them."""

from __future__ import annotations

# What help has a page of.
HELP_PAGES = frozenset({"alarms", "fleet", "move", "see", "share"})

# The pages in other languages. None of them is reserved.
PAGE_ALIASES: dict[str, str] = {
    "alarme": "alarms",
    "bewegen": "move",
    "flotte": "fleet",
    "sehen": "see",
    "teilen": "share",
}

# What people say instead, and what is offered to them.
HINTS: dict[str, str] = {
    "?": "help",
    "commands": "help",
    "go-on": "resume",
    "list": "robots",
    "menu": "help",
    "select": "use",
    "state": "status",
    "unstop": "resume",
}

# What is asked of a robot that its status says, where no skill is called so. None is reserved.
STATUS_WORDS = frozenset({"battery", "where"} | {"akku", "batterie", "wo"})
IS_WORDS = frozenset({"are", "is"} | {"ist", "sind"})

# Words that carry no meaning here. A phrase may contain them ("go to"), a name may not be one.
FILLERS = frozenset({"a", "an", "and", "at", "by", "for", "of", "please", "the", "to", "with", "&"})

# Likewise in other languages, among the values of a command. They are not reserved: where a choice
# is called so, that is meant.
SOFT_FILLERS = frozenset({"bitte", "mit", "nach", "um", "und"})

# Said before or behind a name, where nothing is called so.
POLITE = frozenset({"bitte"})

EVERYTHING = frozenset({"all", "everybody", "everyone", "everything"})
# Likewise elsewhere, where no robot is called so; and what goes along: ``weitermachen lassen``.
EVERYTHING_ELSEWHERE = frozenset({"alle", "alles"})
ALONG_ELSEWHERE = frozenset(
    {"again", "jetzt", "now", "robots", "roboter"} | {"bitte", "lassen", "und", "wieder"}
)
# What leaves out of those named before it whoever is named behind it, where no robot is called so.
EXCEPTING: frozenset[tuple[str, ...]] = frozenset(
    {("but",), ("except",), ("excepting",), ("excluding",), ("minus",), ("not",), ("without",)}
    | {("apart", "from"), ("other", "than"), ("but", "not")}
    | {("ausser",), ("nicht",), ("ohne",), ("aber", "nicht"), ("bis", "auf"), ("nur", "nicht")}
)
NOTHING = frozenset({"nobody", "none", "nothing"})

NUMBERS: dict[str, float] = {
    "half": 0.5,
    "one": 1.0,
    "two": 2.0,
    "three": 3.0,
    "four": 4.0,
    "five": 5.0,
    "six": 6.0,
    "seven": 7.0,
    "eight": 8.0,
    "nine": 9.0,
    "ten": 10.0,
}

# Said, they are numbers, so that the answer can be that they are not finite.
NOT_FINITE: dict[str, float] = {
    sign + word: float(sign + "inf") if word != "nan" else float("nan")
    for sign in ("", "+", "-")
    for word in ("inf", "infinity", "infinite", "∞", "nan")
}
