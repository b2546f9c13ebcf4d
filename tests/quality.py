"""The quality scale of messengers in docs/messengers/quality.md, written from what adapters say.

Run as ``python -m tests.quality``; a test finds a page that is not what is said.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).parents[1]
MESSENGERS: Final = ROOT / "src" / "rosic" / "messengers"
PAGE: Final = ROOT / "docs" / "messengers" / "quality.md"
TIERS: Final = ("bronze", "silver", "gold")
ANSWERS: Final = ("done", "todo", "exempt")
INTRODUCTION: Final = """\
# How good each messenger is

Three tiers: *bronze* is safe to use, *silver* is whole, *gold* does whatever its platform permits.
An adapter has a tier when every rule of it, and of the tiers before it, is done or does not apply:
what a platform itself cannot give stands as *exempt*, with what that means.

`make texts` writes this page of `src/rosic/messengers/quality.toml` and of the `quality.toml` of
each adapter; a test finds what is said and not so.
"""


class QualityRule(NamedTuple):
    """What is asked of every adapter."""

    id: str
    tier: str
    asks: str


class QualityAnswer(NamedTuple):
    """What an adapter says of one rule.

    Attributes:
        kind: One of `ANSWERS`.
        shown_by: Tests, folders and pages, where it is done.
        why: Where it is not.
    """

    kind: str
    shown_by: tuple[str, ...] = ()
    why: str = ""


def rules(folder: Path = MESSENGERS) -> list[QualityRule]:
    """Return what is asked, tier by tier."""
    said = tomllib.loads((folder / "quality.toml").read_text(encoding="utf-8"))
    found = [QualityRule(**rule) for rule in said["rule"]]
    return sorted(found, key=lambda rule: TIERS.index(rule.tier))


def adapters(folder: Path = MESSENGERS) -> dict[str, dict[str, QualityAnswer]]:
    """Return what each adapter says, by the id of a rule."""
    found: dict[str, dict[str, QualityAnswer]] = {}
    for path in sorted(folder.glob("*/quality.toml")):
        said = tomllib.loads(path.read_text(encoding="utf-8"))
        answers = {
            rule: QualityAnswer("done", shown_by=tuple(shown))
            for rule, shown in said.pop("done", {}).items()
        }
        for kind, whys in said.items():
            twice = sorted(set(answers) & set(whys))
            assert not twice, f"{path}: {twice} are answered twice"
            answers |= {rule: QualityAnswer(kind, why=why) for rule, why in whys.items()}
        found[path.parent.name] = answers
    return found


def tier_of(answers: dict[str, QualityAnswer], asked: list[QualityRule]) -> str:
    """Return the best tier that an adapter has; empty for none."""
    best = ""
    for tier in TIERS:
        if any(answers[rule.id].kind == "todo" for rule in asked if rule.tier == tier):
            break
        best = tier
    return best


def untrue(answers: dict[str, QualityAnswer], asked: list[QualityRule]) -> list[str]:
    """Return what is wrong with what one adapter says."""
    known = {rule.id for rule in asked}
    wrong = [f"{rule}: not answered" for rule in sorted(known - set(answers))]
    wrong += [f"{rule}: no such rule" for rule in sorted(set(answers) - known)]
    for rule, answer in answers.items():
        if answer.kind not in ANSWERS:
            wrong.append(f"{rule}: {answer.kind} is no answer")
        elif answer.kind == "done":
            wrong += [f"{rule}: {one} is not there" for one in answer.shown_by if not _is(one)]
            wrong += [f"{rule}: nothing shows it"] * (not answer.shown_by)
        elif not answer.why.endswith("."):
            wrong.append(f"{rule}: no sentence says why")
    return wrong


def _is(shown: str) -> bool:
    """Whether a file or folder is there, and has the test that is named behind it."""
    place, _, test = shown.partition("::")
    path = ROOT / place
    return path.exists() and (not test or f"def {test}(" in path.read_text(encoding="utf-8"))


def page() -> str:
    """Return the page."""
    asked, said = rules(), adapters()
    lines = [INTRODUCTION, "| messenger | tier | done | to do | exempt |", "|---|---|---|---|---|"]
    for name, answers in said.items():
        count = {kind: sum(one.kind == kind for one in answers.values()) for kind in ANSWERS}
        cells = " | ".join(str(count[kind]) for kind in ANSWERS)
        lines.append(f"| [{name}](#{name}) | {tier_of(answers, asked) or 'none'} | {cells} |")
    for name, answers in said.items():
        lines += ["", f"## {name.capitalize()}", "", "| tier | rule | |", "|---|---|---|"]
        lines += [f"| {rule.tier} | {rule.asks} | {_told(answers[rule.id])} |" for rule in asked]
    return "\n".join(lines) + "\n"


def _told(answer: QualityAnswer) -> str:
    if answer.kind == "done":
        return "done: " + ", ".join(f"`{one}`" for one in answer.shown_by)
    return f"{'to do' if answer.kind == 'todo' else answer.kind}: {answer.why}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
