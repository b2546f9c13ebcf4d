"""What a simulated robot's own node would say to ROSIC: it takes on strategies and says so."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import msgspec

from rosic_sim.robots.machines.mecanum import SPEED_LIMIT_M_S
from rosic_sim.robots.machines.omni import Omni

if TYPE_CHECKING:
    from rosic_sim.robots.machines.machine import Machine

CAREFUL = "careful"
SPEED = "speed"


class _Heard(msgspec.Struct, frozen=True):
    """What matters here of what a robot is told."""

    kind: str
    id: str = ""
    name: str = ""
    values: dict[str, float | str] = {}


_read = msgspec.json.Decoder(_Heard).decode
_write = msgspec.json.Encoder().encode


def answer(machine: Machine, words: bytes) -> bytes | None:
    """Do what a robot is told among robots; return what it answers, or None.

    A mobile base takes on ``careful``: no faster than ``speed``, in m/s. An empty name undoes it.
    """
    try:
        heard = _read(words)
    except msgspec.MsgspecError:
        return None
    if heard.kind != "strategy":
        return None
    why = _take_on(machine, heard)
    return _write({"kind": "ack", "id": heard.id, "ok": not why, "why": why})


def _take_on(machine: Machine, heard: _Heard) -> str:
    """Work so from now on; return why not, or nothing."""
    if not isinstance(machine, Omni) or heard.name not in {"", CAREFUL}:
        return "it knows no such strategy"
    speed = heard.values.get(SPEED, SPEED_LIMIT_M_S)
    if not isinstance(speed, float) or not isfinite(speed) or speed <= 0:
        return "the speed is no speed"
    machine.speed_cap_m_s = min(speed, SPEED_LIMIT_M_S) if heard.name else SPEED_LIMIT_M_S
    return ""
