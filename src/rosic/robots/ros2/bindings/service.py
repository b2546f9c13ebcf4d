"""Skills that are service calls: the answer is the receipt, and says whether and what."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.order import OrderEnding, Outcome
from rosic.errors import RobotUnreachable
from rosic.robots.ros2.bindings.answers import BindingAnswer, check_fields
from rosic.robots.ros2.bindings.binding_call import filled
from rosic.robots.ros2.errors import NoAnswer, NotSent
from rosic.robots.ros2.messages.encode import to_message

if TYPE_CHECKING:
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.messages.encode import Values
    from rosic.robots.ros2.profile import ServiceBinding

LAST_WORD_S = 1.0


class ServiceSkill:
    """Calls one service."""

    def __init__(self, binding: ServiceBinding) -> None:
        self._binding = binding
        self._link: ServiceLink | None = None
        self._cls: RosObject = None

    def types(self) -> set[str]:
        """Return the service's type."""
        return {self._binding.type}

    async def open(self, runtime: RosRuntime) -> None:
        """Open the service's client and check the fields of the request."""
        self._cls = runtime.types.service(self._binding.type)
        check_fields(self._cls.Request, self._binding.request)
        self._answer = BindingAnswer(self._cls.Response, self._binding)
        self._link = await runtime.service(self._binding.name, self._binding.type)

    async def close(self) -> None:
        """Leave the service."""
        link, self._link = self._link, None
        if link is not None:
            await link.close()

    async def carry(self, binding_call: BindingCall) -> Outcome:
        """Call it once."""
        link = self._link
        if link is None:
            raise binding_call.offline()
        await binding_call.there(link.sought, link.name)
        values = filled(self._binding.request, binding_call.order)
        to_message(self._cls.Request, values)
        answer = await ask(binding_call, link, values, self._binding.timeout_s, leave=True)
        if answer is None:
            return Outcome(OrderEnding.CANCELLED)
        binding_call.received()
        binding_call.answered(answer)
        words, facts = self._answer.words(answer), self._answer.facts(answer)
        if self._answer.succeeded(answer):
            doubt = self._answer.in_doubt(answer)
            return Outcome(OrderEnding.DONE, joined("; ", filter(None, (words, doubt))), facts)
        ending = OrderEnding.FAILED if binding_call.allowed() else OrderEnding.CANCELLED
        return Outcome(ending, words, facts)


async def ask(
    binding_call: BindingCall,
    link: ServiceLink,
    values: Values,
    timeout_s: float,
    *,
    leave: bool = False,
) -> RosObject:
    """Call a service for an order; None when a stop brought the robot to rest meanwhile.

    Args:
        binding_call: The order.
        link: The service.
        values: Fields of the request.
        timeout_s: For the answer.
        leave: Pass the gate immediately before the request leaves.

    Raises:
        OrderVoid: The gate declined.
        RobotOffline: Nothing was sent.
        RobotUnreachable: It was sent, and nothing came in time.
    """
    call = asyncio.ensure_future(_call(binding_call, link, values, timeout_s, leave=leave))
    halted = asyncio.ensure_future(binding_call.halted.wait())
    try:
        await asyncio.wait({call, halted}, return_when=asyncio.FIRST_COMPLETED)
        if not call.done():
            await asyncio.wait({call}, timeout=LAST_WORD_S)
        if call.done():
            return call.result()
        if binding_call.rest is None or not binding_call.rest.confirmed:
            raise RobotUnreachable(
                said("{shown} has not confirmed the stop.", shown=binding_call.side.shown)
            )
    except NotSent as fault:
        raise binding_call.offline() from fault
    except NoAnswer as fault:
        binding_call.unanswered()
        raise RobotUnreachable(
            said(
                "{shown} has not answered for {timeout_s:g} s.",
                shown=binding_call.side.shown,
                timeout_s=timeout_s,
            )
        ) from fault
    finally:
        call.cancel()
        halted.cancel()
    return None


async def _call(
    binding_call: BindingCall, link: ServiceLink, values: Values, timeout_s: float, *, leave: bool
) -> RosObject:
    # A place among the calls under way may be waited for: the gate is asked after that.
    return await link.call(values, timeout_s=timeout_s, leave=binding_call.leave if leave else None)
