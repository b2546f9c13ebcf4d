"""Random small worlds and questions, from a seed; plain dictionaries, as the oracle takes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from random import Random

Data: TypeAlias = Any  # dictionaries, lists and numbers, as the oracle takes them
NOW = 1_790_000_000_000_000_000
PEOPLE = ("ada", "ben", "cyd", "dee")
WORD = (0.0, 0.0, "word")
VERBS = ("grant", "invite", "lock")
# Name to class and parameters: least, most and unit, SI; a word has none.
SKILLS: dict[str, Data] = {
    "grasp": {"class": "motion", "parameters": {"force": (5.0, 40.0, "N"), "hand": WORD}},
    "move": {
        "class": "motion",
        "parameters": {"speed": (-1.0, 1.0, "m/s"), "distance": (0.0, 5.0, "m")},
    },
    "drive": {"class": "motion", "parameters": {"speed": (0.05, 0.8, "m/s")}},
    "home": {"class": "motion", "parameters": {}},
    "say": {"class": "task", "parameters": {"colour": WORD}},
    "tune": {"class": "config", "parameters": {"force": (0.0, 10.0, "")}},
    "look": {"class": "observe", "parameters": {}},
    "count": {"class": "admin", "parameters": {}},
}
ROBOTS = ("kuka1", "kuka2", "omni")
SAID_ROBOTS = (*["*"] * 6, "kuka1", "omni", "kuka*", "kuka?", "arms", "all", "o*", "xyz")
SAID_SKILLS = (
    *["*"] * 6,
    "grasp",
    "move",
    "drive",
    "g*",
    "?o*",
    "read",
    "look",
    "resume",
    "grant",
    "say",
)
SIGNS = ("<=", "<=", "<=", ">=", "=")
BOUNDS = {
    "speed": ((0.2, 0.5, 0.5, 0.6, -0.5), "m/s"),
    "force": ((10.0, 20.0, 30.0, 6.0), "N"),
    "distance": ((0.2, 0.5, 3.0), "m"),
}
ODD = (("force", "m"), ("hand", ""), ("speed", ""), ("colour", "N"), ("force", ""))
NAMES = ("junior", "plain", "senior", "boss", "loop")


def a_scope(lot: Random) -> tuple[str, str]:
    if lot.random() < 0.12:
        return ("fleet", lot.choice(("*", "grant", "invite", "lock")))
    return (lot.choice(SAID_ROBOTS), lot.choice(SAID_SKILLS))


def some(lot: Random, most: int, make: Data) -> list[Data]:
    return [make(lot) for _ in range(lot.randint(0, most))]


def a_limit(lot: Random) -> tuple[Data, ...]:
    scope = a_scope(lot) if lot.random() < 0.25 else None
    parameter = lot.choice(tuple(BOUNDS))
    numbers, unit = BOUNDS[parameter]
    if lot.random() < 0.08:
        parameter, unit = lot.choice(ODD)
    return (scope, parameter, lot.choice(SIGNS), lot.choice(numbers), unit)


def limits(lot: Random) -> list[Data]:
    return some(lot, 2, a_limit) if lot.random() < 0.5 else []


def an_end(lot: Random) -> int | None:
    return lot.choice((*[None] * 8, NOW - 1, NOW, NOW + 1, NOW + 50))


def a_role(lot: Random) -> dict[str, Data]:
    return {
        "scopes": [a_scope(lot), *some(lot, 2, a_scope)],
        "includes": lot.sample(NAMES, lot.choice((0, 0, 1, 1, 2))),
        "limits": limits(lot),
        "assurance": lot.choice((*[0] * 8, 1, 2)),
        "priority": lot.choice((None, None, 0, 5, 10, 20)),
    }


def a_grant(lot: Random) -> dict[str, Data]:
    bare = lot.random() < 0.2
    return {
        "role": "" if bare else lot.choice((*NAMES, *NAMES, "unknown")),
        "scopes": some(lot, 2, a_scope) if bare or lot.random() < 0.1 else [],
        "robots": [lot.choice(SAID_ROBOTS)] if lot.random() < 0.25 else [],
        "limits": limits(lot),
        "ends": an_end(lot),
    }


def a_care(lot: Random) -> dict[str, Data]:
    return {
        "scopes": [a_scope(lot)],
        "confirm": lot.random() < 0.5,
        "step_up": lot.random() < 0.4,
        "second_person": lot.random() < 0.4,
        "assurance": lot.choice((0, 0, 0, 1, 2)),
    }


def a_world(lot: Random) -> dict[str, Data]:
    robots = lot.sample(ROBOTS, lot.randint(1, 3))
    return {
        "robots": {
            robot: {name: SKILLS[name] for name in lot.sample(list(SKILLS), lot.randint(2, 6))}
            for robot in robots
        },
        "groups": {"arms": ["kuka1", "kuka2"], "all": list(ROBOTS)},
        "verbs": VERBS,
        "roles": {name: a_role(lot) for name in lot.sample(NAMES, lot.randint(3, 5))},
        "care": some(lot, 3, a_care),
        "preempt": [lot.choice(SAID_ROBOTS)] if lot.random() < 0.7 else [],
        "people": {who: [a_grant(lot), *some(lot, 2, a_grant)] for who in PEOPLE[:3]},
    }


def an_argument(lot: Random, name: str, known: Data) -> float | str:
    low, high, unit = known
    if unit == "word":
        return "left"
    numbers, _ = BOUNDS[name]
    near = lot.choice(numbers)
    return lot.choice((low, high, near, near, near * 1.01, -near, (low + high) / 2, float("nan")))


def a_case(lot: Random, world: dict[str, Data]) -> dict[str, Data]:
    robot = lot.choice((*list(world["robots"]) * 6, "fleet", "nowhere"))
    own = list(world["robots"].get(robot, ()))
    skill = lot.choice((*own * 4, "read", "resume", "stop", "grant", "invite", "lock", "grasp"))
    known = world["robots"].get(robot, {}).get(skill, {}).get("parameters", {})
    arguments: dict[str, Data] | None = {n: an_argument(lot, n, known[n]) for n in known}
    if lot.random() < 0.3:
        arguments = None
    who = lot.choice((*PEOPLE[:3] * 4, PEOPLE[3]))
    return {
        "who": who,
        "robot": robot,
        "skill": skill,
        "arguments": arguments,
        "channel": lot.choice((0, 0, 1, 2)),
        "now": NOW,
        "key": a_key(lot, who),
        "locked": [lot.choice(PEOPLE)] if lot.random() < 0.1 else [],
        "stopped": lot.random() < 0.1,
        "holder": lot.choice((None, None, *PEOPLE)),
        "until": lot.choice((None, NOW + 7)),
        "slots": lot.choice(("none", "respected", "required")),
        "slot": a_slot(lot),
        "next": lot.choice((None, NOW + 9)),
        "stepped_up": lot.random() < 0.5,
        "confirmed": lot.random() < 0.5,
        "second": lot.choice((None, *PEOPLE)),
    }


def a_key(lot: Random, who: str) -> dict[str, Data] | None:
    if lot.random() < 0.02:
        return None
    return {
        "owner": who if lot.random() < 0.97 else lot.choice(PEOPLE),
        "revoked": lot.random() < 0.03,
        "ends": an_end(lot) if lot.random() < 0.1 else None,
        "scopes": [a_scope(lot), a_scope(lot)] if lot.random() < 0.15 else [],
    }


def a_slot(lot: Random) -> dict[str, Data] | None:
    start, end = lot.choice(
        ((NOW - 5, NOW), (NOW - 5, NOW + 1), (NOW, NOW + 5), (NOW + 1, NOW + 5))
    )
    owner = lot.choice((None, *PEOPLE))
    return None if owner is None else {"owner": owner, "start": start, "end": end}
