"""What a profile says of alarms: when, for how long, whom to tell, and what the robot does then."""

from __future__ import annotations

import enum

import msgspec


class Severity(enum.Enum):
    """How much it matters. A critical alarm overtakes what is not urgent."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    INFO = "info"
    WARNING = "warning"
    CRITICAL = "critical"


class RecipientCircle(enum.Enum):
    """Who is told first; an alarm that nobody has seen goes on to the next."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    HOLDER = "holder"
    OPERATORS = "operators"
    ADMINS = "admins"


CIRCLES = tuple(RecipientCircle)


class AlertConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One rule about what a robot reports.

    Attributes:
        name: Of the rule, as people type it.
        when: ``battery < 20 %``, ``temperature outside 15 to 30 °C``, ``mode is manual``,
            ``link_age > 5 s``, ``offline``, ``silent``.
        lasting: For how long without a break, before anybody is told.
        clear: When it is over, if not a twentieth beyond the threshold: ``battery > 25 %``.
        say: What people read; the name of the rule if nothing is said.
        severity: How much it matters.
        tell: Who is told first: whoever has the robot, who may operate it, or the admins.
        escalate_after: The next circle is told after so long, until somebody has seen it.
        run: What the robot does then, as people would type it: ``home``; or ``stop``, ``pause``,
            ``reallocate``.
        author: Whose right it is run with: the name of a person in the configuration.
        run_every: It is run at most this often.
    """

    name: str
    when: str
    lasting: str = msgspec.field(name="for", default="5 s")
    clear: str = ""
    say: str = ""
    severity: Severity = Severity.WARNING
    tell: RecipientCircle = RecipientCircle.OPERATORS
    escalate_after: str = ""
    run: str = ""
    author: str = msgspec.field(name="as", default="")
    run_every: str = "10 min"

    def __post_init__(self) -> None:
        if bool(self.run) != bool(self.author):
            raise ValueError("run and as belong together: what is run, and by whose right")
