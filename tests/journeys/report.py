"""What is printed after a journey."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import Sequence

    from tests.journeys.killing import Plan
    from tests.journeys.verdict import Verdict

SHOWN = 12


class Report(NamedTuple):
    """One kill journey in figures.

    Attributes:
        ready_s: Per restart that was let become ready: from its start until it listened.
        moments: How many kills at which kind of moment.
        duplicated: How many updates were given out twice on purpose.
        unanswered: Resumes whose answer was lost with the gateway: unlike the end of a command,
            it is not on disk before it is told.
    """

    plan: Plan
    took_s: float
    verdict: Verdict
    ready_s: Sequence[float]
    moments: Counter[str]
    commands: int
    actuations: int
    stops: int
    duplicated: int
    resumes: int
    unanswered: int

    def text(self) -> str:
        """Return it as lines."""
        plan, verdict = self.plan, self.verdict
        endings = ", ".join(f"{end.value} {count}" for end, count in verdict.endings.most_common())
        moments = ", ".join(f"{moment} {count}" for moment, count in sorted(self.moments.items()))
        duplicates = sum(one.startswith("I1") for one in verdict.wrong)
        said = f"{self.commands} commands, {self.actuations} actuations, {self.stops} stops"
        ready = [f"p{share} {percentile(self.ready_s, share):.2f} s" for share in (50, 99)]
        lines = [
            f"kill journey, seed {plan.seed}, fault: {plan.fault or 'none'}",
            f"  {self.moments.total()} kills in {self.took_s:.1f} s ({moments})",
            f"  {said}, {self.duplicated} updates duplicated by the server",
            f"  endings: {endings}",
            f"  duplicate actuations: {duplicates}; untold: {verdict.untold}",
            f"  said again after a restart, and marked so: {verdict.said_again}",
            f"  {self.resumes} resumes, of which {self.unanswered} were never answered",
            f"  ready after a restart: {', '.join(ready)}",
            f"  wrong: {len(verdict.wrong)}",
            *(f"    {one}" for one in verdict.wrong[:SHOWN]),
        ]
        return "\n".join(lines)


def percentile(values: Sequence[float], share: float) -> float:
    """Return the value below which this share of all lies; 0 for none."""
    if not values:
        return 0.0
    ranked = sorted(values)
    return ranked[min(len(ranked) - 1, int(len(ranked) * share / 100))]
