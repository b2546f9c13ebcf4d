"""The rules of authority once more: slow, plain, and sharing nothing with the product.

It judges plain dictionaries; everything is worked out anew for every question. ``w`` is the world.
"""

from __future__ import annotations

from typing import Any, TypeAlias

Data: TypeAlias = Any  # dictionaries, lists and numbers


def like(pattern: str, text: str) -> bool:
    if pattern[:1] == "*":
        return like(pattern[1:], text) or (text != "" and like(pattern, text[1:]))
    if not pattern or not text:
        return pattern == text
    return pattern[0] in ("?", text[0]) and like(pattern[1:], text[1:])


def means(w: Data, said: str, robot: str) -> bool:
    if said in ("fleet", *w["robots"]) or robot not in w["robots"]:
        return bool(said == robot)
    return robot in w["groups"][said] if said in w["groups"] else like(said, robot)


def own(w: Data, robot: str) -> Data:
    return {v: {} for v in w["verbs"]} if robot == "fleet" else w["robots"].get(robot, {})


def gives(w: Data, scope: Data, robot: str, skill: str) -> bool:
    if scope[0] == "fleet" and robot in w["robots"]:
        return skill in ("read", "grant") and like(scope[1], "grant")
    words = [*own(w, robot), *(() if robot == "fleet" else ("read", "resume"))]
    hit = [word for word in words if like(scope[1], word)]
    hit += ["grant"] if scope[1] == "grant" else []
    looks = own(w, robot).get(skill, {}).get("class") == "observe" and "read" in hit
    return means(w, scope[0], robot) and (skill in hit or (skill == "read" and hit != []) or looks)


def cared(w: Data, scope: Data, robot: str, skill: str) -> bool:
    named = skill == scope[1] and skill in (*own(w, robot), "read", "resume", "grant")
    wild = like(scope[1], skill) and skill in own(w, robot)
    return means(w, scope[0], robot) and (named or wild)


def bounds(w: Data, level: Data, robot: str, skill: str, name: str) -> Data:
    """Name, least and most; None: no such limit; False: nothing is left."""
    mine = [i for i in level if i[1] == name and (not i[0] or gives(w, i[0], robot, skill))]
    floor, ceiling, kind = own(w, robot)[skill]["parameters"][name]
    if not mine or any(said not in ("", kind) or kind == "word" for *_, said in mine):
        return False if mine else None
    lows = [number for _, _, sign, number, _ in mine if sign in (">=", "=")]
    highs = [number for _, _, sign, number, _ in mine if sign in ("<=", "=")]
    if not lows and floor < 0 <= min(highs):
        lows = [-min(highs)]
    low, high = max(lows, default=-9e9) - 1e-7, min(highs, default=9e9) + 1e-7
    return max(low, floor) <= min(high, ceiling) and (name, low, high)


def paths(w: Data, name: str, seen: Data = ()) -> Data:
    """(scopes, limits of each role on the way, assurance) of a role and all it includes."""
    if name not in w["roles"] or name in seen:
        return []
    role = w["roles"][name]
    mine: Data = [(role["scopes"], [], 0)]
    mine += [path for below in role["includes"] for path in paths(w, below, (*seen, name))]
    return [(s, [role["limits"], *ls], max(role["assurance"], a)) for s, ls, a in mine]


def rank(w: Data, name: str, seen: Data = ()) -> Data:
    role = w["roles"].get(name) if name not in seen else None
    if role is None or role["priority"] is not None:
        return role["priority"] if role else 0
    return max((rank(w, below, (*seen, name)) for below in role["includes"]), default=0)


def ways(w: Data, grants: Data, robot: str, skill: str) -> Data:
    """(end, priority, assurance, limits) of whatever gives a skill."""
    for grant in grants:
        here = not grant["robots"] or any(means(w, said, robot) for said in grant["robots"])
        for scopes, levels, least in [*paths(w, grant["role"]), (grant["scopes"], [], 0)]:
            if here and any(gives(w, scope, robot, skill) for scope in scopes):
                names = own(w, robot).get(skill, {}).get("parameters", ())
                every = (*levels, grant["limits"])
                limits = [bounds(w, level, robot, skill, n) for level in every for n in names]
                if False not in limits:
                    yield grant["ends"], rank(w, grant["role"]), least, [b for b in limits if b]


def judge(w: Data, c: Data) -> Data:  # noqa: C901, PLR0911, PLR0912, PLR0915 - rule after rule
    """Return the code of a refusal, or (needs, from whom the robot is taken over, priority)."""
    me, robot, skill, now, key = c["who"], c["robot"], c["skill"], c["now"], c["key"]

    def live(who: str, word: str) -> Data:
        every = ways(w, w["people"].get(who, ()), robot, word)
        return [way for way in every if way[0] is None or now < way[0]]

    def beats(rank_: int, who: Data) -> bool:
        allowed = any(means(w, said, robot) for said in w["preempt"])
        return allowed and rank_ > max((way[1] for way in live(who, "read")), default=0)

    def reach(word: str) -> bool:
        return not key["scopes"] or any(gives(w, scope, robot, word) for scope in key["scopes"])

    if key is None or key["owner"] != me:
        return "key-unknown"
    if key["revoked"] or (key["ends"] or now + 1) <= now:
        return "key-revoked" if key["revoked"] else "key-expired"
    if me in c["locked"] and skill != "stop":
        return "locked"
    if not live(me, "read") or not reach("read"):
        return "no-such-robot"
    if skill == "stop":
        return [], [], 0
    if not reach(skill):
        return "key-too-narrow"
    if not (mine := live(me, skill)):
        ever = list(ways(w, w["people"].get(me, ()), robot, skill))
        return "right-ended" if ever else "not-granted"
    care = [i for i in w["care"] if any(cared(w, scope, robot, skill) for scope in i["scopes"])]
    least = max((i["assurance"] for i in care), default=0)
    if not (near := [way for way in mine if c["channel"] >= max(way[2], least)]):
        return "channel-too-weak"
    said = c["arguments"]
    if said is not None:
        near = [way for way in near if all(low <= said[n] <= high for n, low, high in way[3])]
        if not near:
            return "over-limit"
    free = [way[1] for way in near if said is not None or not way[3]]
    rank_ = max(free) if free else min(way[1] for way in near)
    others: list[Data] = []
    if own(w, robot).get(skill, {}).get("class") in ("motion", "task", "config"):
        slot = c["slot"] if c["slot"] and c["slot"]["start"] <= now < c["slot"]["end"] else None
        owner = slot["owner"] if slot and c["slots"] != "none" else None
        others = [p for p in dict.fromkeys((owner, c["holder"])) if p not in (None, me)]
        if c["stopped"]:
            return "robot-stopped"
        if c["slots"] == "required" and not slot:
            return "slot-needed"
        if not all(beats(rank_, other) for other in others):
            return "slot-taken" if owner in others and not beats(rank_, owner) else "robot-taken"
    theirs = live(c["second"], skill) if c["second"] not in (None, me, *c["locked"]) else []
    if said is not None:
        theirs = [way for way in theirs if all(low <= said[n] <= high for n, low, high in way[3])]
    agreed = theirs != []
    done = {"confirm": c["confirmed"], "step_up": c["stepped_up"], "second_person": agreed}
    return [n for n in done if any(i[n] for i in care) and not done[n]], others, rank_
