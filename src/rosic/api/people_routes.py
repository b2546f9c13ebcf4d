"""The routes of invitations, of who asks for a right, and of roles.

What changes something is said as a line, so that it passes what the chat passes: rights, questions
that are asked before, the record.
"""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Final

from litestar import delete, get, post, put
from litestar.params import FromPath, JSONBody
from litestar.status_codes import HTTP_200_OK, HTTP_201_CREATED

from rosic.api.lines import one_line, one_word
from rosic.api.people_schemas import (
    AccessRequestIn,
    AccessRequestOut,
    AllowIn,
    GrantIn,
    InvitationIn,
    InvitationOut,
    InviteLinkOut,
    NewInvitationOut,
    RightsCheckIn,
    RightsDecisionOut,
    RoleIn,
    RoleOut,
)
from rosic.api.routes import Api, Speech, Who
from rosic.api.schemas import AnswerOut, moment
from rosic.authoriser.invite_codes import HALF, join_text, qr_png
from rosic.contracts.messenger import invite_link_of
from rosic.core.i18n import said
from rosic.core.policy.scope import FLEET, GRANT
from rosic.core.secret import Secret
from rosic.errors import NotFound, NotPermitted, NotUnderstood

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.authoriser.invitations import Invitation
    from rosic.gateway.pending_work import PendingRequest

INVITE: Final = "invite"
MAY_NOT_INVITE: Final = said("Invitations are shown to whoever may invite.")
MAY_NOT_GIVE: Final = said("Roles are shown to whoever gives rights.")
NO_INVITATION: Final = said("There is no such invitation that is open.")
NO_REQUEST: Final = said("Nobody waits for your answer under that id, or not any more.")
EXPLAINED_TO_ADMINS: Final = said(
    "What others may, and why, is shown to whoever looks after people."
)
UNKNOWN_PERSON: Final = said("Nobody is known by that id here.")

# ---- invitations ----


@get("/invitations", summary="Invitations that are open", tags=["people"])
async def invitations(api: Api, caller: Who) -> list[InvitationOut]:
    """Return the invitations that are open, for whoever may invite. No code is among them."""
    return [_invitation(api, caller, one) for one in _open(api, caller)]


@post("/invitations", status_code=HTTP_201_CREATED, summary="Invite somebody", tags=["people"])
async def invite(
    api: Api, speech: Speech, caller: Who, data: JSONBody[InvitationIn]
) -> NewInvitationOut:
    """Make an invitation, as `/invite` does. Its code is told this once."""
    named = f" as {one_line(data.name)}" if data.name.strip() else ""
    answer = await speech.settled(caller, f"/invite {one_line(data.rights)}{named}")
    made = api.kernel.access.enrolment.invitations
    for code in api.kernel.access.codes_in(answer.text):
        found = made.find(code)
        if found is not None:
            shown = Secret(f"{code[:HALF]}-{code[HALF:]}")
            return _new(api, caller, found, shown, answer.text)
    raise NotUnderstood(answer.text)


@delete(
    "/invitations/{invitation:str}",
    status_code=HTTP_200_OK,
    summary="Take an invitation back",
    tags=["people"],
)
async def withdraw(api: Api, speech: Speech, caller: Who, invitation: FromPath[str]) -> AnswerOut:
    """Take an invitation back: nobody comes in by it any more."""
    if invitation not in {one.id for one in _open(api, caller)}:
        raise NotFound(NO_INVITATION)
    return await speech.command(caller, f"/invite back {invitation}")


def _open(api: ApiContext, caller: ApiCaller) -> tuple[Invitation, ...]:
    """Return the invitations that are open.

    Raises:
        NotPermitted: They are not theirs to see.
    """
    if not api.holds(caller, FLEET, INVITE):
        raise NotPermitted(MAY_NOT_INVITE)
    return api.kernel.access.enrolment.invitations.open()


def _invitation(api: ApiContext, caller: ApiCaller, one: Invitation) -> InvitationOut:
    return InvitationOut(
        id=one.id,
        gives=api.callers.read_by(one.given.words, caller),
        by=api.kernel.rooms.authoriser.directory.name(one.issuer),
        own=one.issuer == caller.principal,
        asks=one.needs_confirmation,
        expires=moment(one.expires_ns),
    )


def _new(
    api: ApiContext, caller: ApiCaller, found: Invitation, code: Secret, text: str
) -> NewInvitationOut:
    links = tuple(
        InviteLinkOut(messenger.name, link)
        for messenger in api.kernel.messengers
        if (link := invite_link_of(messenger, code))
    )
    typed = join_text(code)
    picture = b64encode(qr_png(links[0].url if links else typed)).decode()
    return NewInvitationOut(
        _invitation(api, caller, found),
        code.reveal(),
        typed,
        links,
        f"data:image/png;base64,{picture}",
        text,
    )


# ---- who asks for what ----


@get("/access-requests", summary="Who waits for an answer", tags=["people"])
async def access_requests(api: Api, caller: Who) -> list[AccessRequestOut]:
    """Return who waits for the caller's answer, and what the caller waits for."""
    pending = api.kernel.shared.pending.find()
    if pending is None or api.is_locked_out(caller):
        return []
    theirs = [_request(api, caller, one) for one in pending.waiting_for(caller.principal)]
    own = (_request(api, caller, one, own=True) for one in pending.asked_by(caller.principal))
    return [*theirs, *own]


@post(
    "/access-requests",
    status_code=HTTP_201_CREATED,
    summary="Ask for a right for a while",
    tags=["people"],
)
async def ask(api: Api, speech: Speech, caller: Who, data: JSONBody[AccessRequestIn]) -> AnswerOut:
    """Ask whoever may give a right for it, as `/ask` does."""
    profile = api.kernel.rooms.profiles.get(data.robot)
    named = data.robot if profile is None else api.profile(caller, data.robot).id
    line = f"/ask {one_word(named)} {one_word(data.right)} for {data.minutes} min"
    return await speech.command(caller, line)


@post(
    "/access-requests/{request_id:str}/allow",
    status_code=HTTP_200_OK,
    summary="Say yes",
    tags=["people"],
)
async def allow(
    api: Api, speech: Speech, caller: Who, request_id: FromPath[str], data: JSONBody[AllowIn]
) -> AnswerOut:
    """Let somebody in, or give them what they asked for, as `/approve` does."""
    found = _waiting(api, caller, request_id)
    seconds = f" {data.minutes * 60}" if data.minutes and found.kind == "right" else ""
    return await speech.command(caller, f"/approve {found.id}{seconds}")


@post(
    "/access-requests/{request_id:str}/deny",
    status_code=HTTP_200_OK,
    summary="Say no",
    tags=["people"],
)
async def deny(api: Api, speech: Speech, caller: Who, request_id: FromPath[str]) -> AnswerOut:
    """Do not let somebody in, or do not give them what they asked for, as `/decline` does."""
    return await speech.command(caller, f"/decline {_waiting(api, caller, request_id).id}")


def _waiting(api: ApiContext, caller: ApiCaller, request: str) -> PendingRequest:
    """Return what somebody may answer.

    Raises:
        NotFound: Nobody waits for their answer under that id.
    """
    pending = api.kernel.shared.pending.find()
    waiting = () if pending is None else pending.waiting_for(caller.principal)
    for one in waiting:
        if one.id == request:
            return one
    raise NotFound(NO_REQUEST)


def _request(
    api: ApiContext, caller: ApiCaller, one: PendingRequest, *, own: bool = False
) -> AccessRequestOut:
    what = api.callers.read_by(one.what, caller)
    return AccessRequestOut(one.id, one.kind, one.who, what, one.words, own, moment(one.until_ns))


# ---- roles and rights ----


@get("/roles", summary="Which roles there are", tags=["people"])
async def roles(api: Api, caller: Who) -> list[RoleOut]:
    """Return every role, for whoever gives rights on anything here."""
    robots = (FLEET, *api.kernel.rooms.profiles)
    if not any(api.holds(caller, robot, GRANT) for robot in robots):
        raise NotPermitted(MAY_NOT_GIVE)
    book = api.kernel.enforcer.policy.rolebook
    return [
        RoleOut(name, role.scopes, role.includes, role.limits, name in book.own)
        for name, role in book.rulebook.roles.items()
    ]


@put("/roles/{role:str}", status_code=HTTP_200_OK, summary="Make a role", tags=["people"])
async def make_role(
    speech: Speech, caller: Who, role: FromPath[str], data: JSONBody[RoleIn]
) -> AnswerOut:
    """Make a role of the place's own, or another of it, as `/role` does: it asks first."""
    return await speech.command(caller, f"/role {one_word(role)} may {one_line(data.gives)}")


@delete("/roles/{role:str}", status_code=HTTP_200_OK, summary="Take a role back", tags=["people"])
async def take_role(speech: Speech, caller: Who, role: FromPath[str]) -> AnswerOut:
    """Take a role of the place's own back, as `/role` does; nobody may have it any more."""
    return await speech.command(caller, f"/role {one_word(role)} off")


@post(
    "/people/{person:str}/rights",
    status_code=HTTP_200_OK,
    summary="Give somebody rights",
    tags=["people"],
)
async def give(
    api: Api, speech: Speech, caller: Who, person: FromPath[str], data: JSONBody[GrantIn]
) -> AnswerOut:
    """Give somebody who is known here rights, as `/grant` does: it asks first."""
    known = {one.id for one in api.kernel.rooms.authoriser.directory.people()}
    if person not in known or not api.holds(caller, FLEET, "people"):
        raise NotFound(UNKNOWN_PERSON)
    return await speech.command(caller, f"/grant {person} {one_line(data.rights)}")


@post(
    "/rights/check",
    status_code=HTTP_200_OK,
    summary="What somebody may, and why",
    tags=["people"],
)
async def explain(api: Api, caller: Who, data: JSONBody[RightsCheckIn]) -> list[RightsDecisionOut]:
    """Return what would be decided if somebody said a line now, with every rule that was asked.

    For whoever looks after people. Nothing is done, counted or written.
    """
    api.check_admin(caller, EXPLAINED_TO_ADMINS)
    explainer = api.kernel.shared.explainer.get()
    return [
        RightsDecisionOut(one.allowed, one.text)
        for one in explainer.explained(data.person, one_line(data.line))
    ]


ROUTES: Final = (
    invitations,
    invite,
    withdraw,
    access_requests,
    ask,
    allow,
    deny,
    roles,
    make_role,
    take_role,
    give,
    explain,
)
