"""What decides is made with what it decides by; nobody can forget it (I8, I18)."""

from __future__ import annotations

import inspect

import msgspec
import pytest

from rosic.app.maintenance import Maintenance
from rosic.authoriser.button_tokens import ButtonTokens
from rosic.config.profiles import known_units
from rosic.container.container import Containers
from rosic.core.policy.query import PolicyState
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.features.access.approve import ApprovalCommands
from rosic.features.access.newcomer_chat import NewcomerChat
from rosic.features.alerts.actions import ActionQueries
from rosic.gateway.access_registry import AccessRegistry
from rosic.gateway.delivery.notifier import Notifier
from rosic.gateway.delivery.redaction import SecretRedaction
from rosic.gateway.delivery.sender import ChatSender
from rosic.gateway.feature import Kernel
from rosic.gateway.policy_service import PolicyEnforcer, PolicyService
from rosic.gateway.stop import StopLane
from rosic.linker.linker import Linker
from rosic.organiser.calendar import Calendar
from rosic.organiser.organiser import AccessState, Organiser
from rosic.testing.clock import ManualClock

DECIDED_BY = [
    (Organiser, "policy"),
    (Linker, "policy"),
    (Kernel, "enforcer"),
    (Kernel, "access"),
    (Maintenance, "kernel"),
    (Containers, "usual"),
    (Calendar, "names"),
    (PolicyEnforcer, "changes"),
    (AccessRegistry, "stops"),
    (AccessState, "calendar"),
    (Notifier, "outbox"),
    (StopLane, "outbox"),
    (ChatSender, "gone"),
    (SecretRedaction, "note"),
    (ButtonTokens, "count"),
    (ActionQueries, "author_of"),
    (ActionQueries, "tasks"),
    (NewcomerChat, "count"),
    (ApprovalCommands, "forget"),
    (SecretRedaction, "is_good"),
]


@pytest.mark.parametrize(("kind", "argument"), DECIDED_BY)
def test_nothing_that_decides_is_made_without_what_it_decides_by(kind: type, argument: str) -> None:
    parameter = inspect.signature(kind).parameters[argument]
    assert parameter.default is inspect.Parameter.empty


@pytest.mark.parametrize("told", ["locked", "stopped", "holder", "slots", "slot"])
def test_nothing_is_decided_without_what_may_stand_in_the_way(told: str) -> None:
    field = next(each for each in msgspec.structs.fields(PolicyState) if each.name == told)
    assert field.required


def test_every_change_of_the_rights_is_in_force_at_once() -> None:
    policy = PolicyService(
        RoleRules(roles=DEFAULT_ROLES), (), known_units(), ManualClock(), lambda _who: ()
    )
    held, seen = policy.in_force, [policy.in_force.epoch]
    for change in (policy.draw_up, policy.moved, lambda: policy.renew("p-1")):
        change()
        assert held.rights is policy.rights
        assert held.epoch == policy.rights.epoch
        seen.append(held.epoch)
    assert seen == sorted(set(seen))
