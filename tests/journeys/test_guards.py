"""Each journey was seen to fail when a guard is taken out of the source it runs on."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from tests.journeys.running import ROOT
from tests.pace import pace
from tests.planted.faults import Fault

if TYPE_CHECKING:
    from pathlib import Path

TESTS_FAILED = 1
JOURNEYS = "tests/journeys"
KILLS = f"{JOURNEYS}/test_kills.py::test_nothing_is_done_twice_and_everything_is_told_over_20_kills"
CONTESTED = "test_while_somebody_else_receives_nothing_moves_and_stops_work"

GUARDS = (
    Fault(
        name="I5 a stop is queued like everything else",
        file="gateway/pipeline.py",
        guard="if urgent is not None and await self._urgent.take(messenger, inbound, urgent):",
        without=(
            "if urgent is not None and not await asyncio.sleep(3.0)"
            " and await self._urgent.take(messenger, inbound, urgent):"
        ),
        caught_by=(f"{JOURNEYS}/test_stops.py::test_a_stop_overtakes_what_waits",),
    ),
    Fault(
        name="I9 the order is relayed though the claim failed",
        file="container/container.py",
        guard=(
            "            raise RecordUnavailable(\n                said(\n"
            '                    "I cannot write down what'
        ),
        without=(
            "            return orders\n"
            "            raise RecordUnavailable(\n                said(\n"
            '                    "I cannot write down what'
        ),
        caught_by=(f"{JOURNEYS}/test_stops.py",),
    ),
    Fault(
        name="I10 a stop is kept in memory only",
        file="linker/linker.py",
        guard="*(self._latch.write(s.robot, s.generation, latched=True) for s in stops),",
        without="",
        caught_by=(f"{JOURNEYS}/test_stops.py",),
    ),
    Fault(
        name="I2 old motion is carried out",
        file="gateway/requests.py",
        guard="if now_ns > request.deadline_ns:",
        without="if False:",
        caught_by=(f"{JOURNEYS}/test_backlog.py",),
    ),
    Fault(
        name="I2 what was sent while nobody listened is carried out",
        file="gateway/requests.py",
        guard="if request.skill.actuates and inbound.sent_ns < inbound.listening_since_ns:",
        without="if False:",
        caught_by=(f"{JOURNEYS}/test_backlog.py",),
    ),
    Fault(
        name="I5 an older resume undoes a younger stop",
        file="gateway/resume.py",
        guard="inbound.received_ns <= stopped_ns or inbound.sent_ns + SECOND_NS < stopped_ns:",
        without="False:",
        caught_by=(
            f"{JOURNEYS}/test_backlog.py::test_a_resume_that_a_stop_overtakes_does_not_undo_it",
        ),
    ),
    Fault(
        name="I17 edited and forwarded messages are accepted",
        file="gateway/pipeline.py",
        guard="if inbound.standing is not FRESH and inbound.standing is not UNVERIFIED:",
        without="if False:",
        caught_by=(f"{JOURNEYS}/test_inert.py",),
    ),
    Fault(
        name="I16 a button works twice",
        file="authoriser/button_tokens.py",
        guard="        del self._bound[nonce]\n",
        without="",
        caught_by=(f"{JOURNEYS}/test_buttons.py::test_a_button_pressed_twice_acts_once",),
    ),
    Fault(
        name="I16 anybody's tap counts",
        file="authoriser/button_tokens.py",
        guard="if bound.principal not in {principal, ANYBODY} or bound.chat != inbound.chat.id:",
        without="if False:",
        caught_by=(f"{JOURNEYS}/test_buttons.py::test_another_person_cannot_press_it",),
    ),
    Fault(
        name="I16 a button survives a gap",
        file="authoriser/button_tokens.py",
        guard="missed = bound.issued.wall_ns < inbound.listening_since_ns and not bound.still",
        without="missed = False",
        caught_by=(
            f"{JOURNEYS}/test_buttons.py::test_a_button_from_before_a_gap_in_listening_is_dead",
        ),
    ),
    Fault(
        name="motion goes on while somebody else receives",
        file="messengers/telegram/polling_gap.py",
        guard="        self._freeze()\n        self._calm_from_ns",
        without="        self._calm_from_ns",
        caught_by=(f"{JOURNEYS}/test_account.py::{CONTESTED}",),
    ),
    Fault(
        name="a revocation is kept in memory only",
        file="gateway/transactions.py",
        guard=(
            "            await self._store.write(*records)\n"
            "        except StoreFault as fault:\n            raise RecordUnavailable("
        ),
        without=(
            "            pass\n"
            "        except StoreFault as fault:\n            raise RecordUnavailable("
        ),
        caught_by=(f"{JOURNEYS}/test_account.py::test_somebody_revoked_stays_revoked_over_a_kill",),
    ),
    Fault(
        name="L1 an order that was refused after its claim is not told after a kill",
        file="gateway/recovery.py",
        guard="if order.robot:",
        without='if order.ending != "refused":',
        caught_by=(KILLS,),
    ),
    Fault(
        name="I7 robots that were commanded together are told of one by one after a kill",
        file="gateway/recovery.py",
        guard="    before = cards.setdefault(key, told)\n",
        without="    key = order.cid\n    before = cards.setdefault(key, told)\n",
        caught_by=(KILLS,),
    ),
    Fault(
        name="I7 a group's command that was claimed is told to be refused after a kill",
        file="gateway/requests.py",
        guard="robot_command_id(cid, robot) if requests else cid,",
        without="robot_command_id(cid, robot),",
        caught_by=(f"{JOURNEYS}/test_given_again.py",),
    ),
)


@pytest.mark.parametrize("fault", GUARDS, ids=[fault.name for fault in GUARDS])
def test_the_guard_is_where_the_campaign_looks_for_it(fault: Fault) -> None:
    text = (ROOT / "src" / "rosic" / fault.file).read_text(encoding="utf-8")
    assert text.count(fault.guard) == 1


@pytest.mark.campaign
@pytest.mark.limit(300)
@pytest.mark.parametrize("fault", GUARDS, ids=[fault.name for fault in GUARDS])
def test_the_journey_needs_its_guard(fault: Fault, tmp_path: Path) -> None:
    source = tmp_path / "src"
    shutil.copytree(
        ROOT / "src" / "rosic", source / "rosic", ignore=shutil.ignore_patterns("__pycache__")
    )
    file = source / "rosic" / fault.file
    text = file.read_text(encoding="utf-8")
    assert text.count(fault.guard) == 1, f"{fault.file} has changed: the fault must be planted anew"
    file.write_text(text.replace(fault.guard, fault.without), encoding="utf-8")

    run = subprocess.run(  # noqa: S603 - our own tests
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-x",
            f"--basetemp={tmp_path / 'runs'}",
            *fault.caught_by,
        ],
        cwd=ROOT,
        env={
            **os.environ,
            "PYTHONPATH": str(source),
            "PYTHONDONTWRITEBYTECODE": "1",
            "ROSIC_KILLS": "60",  # chance decides whether a kill hits what is wrong
        },
        capture_output=True,
        text=True,
        timeout=280 * pace(),
        check=False,
    )

    assert run.returncode == TESTS_FAILED, f"nothing noticed: {run.stdout[-2000:]}"
