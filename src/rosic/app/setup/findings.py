"""What a look at something brought."""

from __future__ import annotations

import enum
from typing import NamedTuple


class FindingVerdict(enum.Enum):
    """What follows from a finding; the text people read is the value."""

    GOOD = "good"
    LOOK = "look at this"
    NOT_MEASURED = "not measured"


class DiagnosticFinding(NamedTuple):
    """One finding.

    Attributes:
        about: One or two words: ``disk``, ``omni``.
        text: Figures, and what to do about them where something should be done.
    """

    about: str
    verdict: FindingVerdict
    text: str

    def __str__(self) -> str:
        mark = "" if self.verdict is FindingVerdict.GOOD else f"{self.verdict.value}: "
        return f"{self.about:<10} {mark}{self.text}"
