"""Logging in and out, and joining by a one-time link."""

from __future__ import annotations

from fastapi import APIRouter, Depends, Request, Response

from db.people_records import AccountRecord
from server.api.common import ERRORS, Needs, TheAccess, change_of
from server.people.access import COOKIE
from server.people.accounts import SESSION_S
from server.people.actor import Actor
from server.people.audit import AuditedRoute
from server.schemas.people import JoinIn, LoginIn, MeOut

router = APIRouter(tags=["people"], responses=ERRORS, route_class=AuditedRoute)


@router.get("/session", summary="Who am I?", operation_id="get_session")
async def get_session(access: TheAccess, request: Request) -> MeOut:
    """Return who you are logged in as."""
    actor = access.actor_of(request)
    return MeOut(name=actor.name, role=actor.role, login=not access.is_open)


@router.post("/session", status_code=201, summary="Log in", operation_id="log_in")
async def log_in(body: LoginIn, access: TheAccess, request: Request, response: Response) -> MeOut:
    """Begin a session, kept in a cookie that pages cannot read."""
    sender = request.client.host if request.client is not None else "nowhere"
    secret, account = await access.accounts.log_in(body.name, body.password, sender)
    return await _begin(request, response, secret, account)


@router.delete(
    "/session",
    status_code=204,
    summary="Log out",
    operation_id="log_out",
    dependencies=[Depends(Needs("viewer"))],
)
async def log_out(access: TheAccess, request: Request, response: Response) -> None:
    """End the session: every page and stream of it is closed."""
    secret = request.cookies.get(COOKIE)
    if secret is not None:
        await access.accounts.log_out(secret)
    response.delete_cookie(COOKIE, path="/")


@router.post("/join", status_code=201, summary="Join by a link", operation_id="join_by_link")
async def join_by_link(body: JoinIn, access: TheAccess, request: Request, response: Response) -> MeOut:
    """Make an account with a one-time link and log in."""
    secret, account = await access.accounts.join(body.secret, body.name, body.password)
    return await _begin(request, response, secret, account)


async def _begin(request: Request, response: Response, secret: str, account: AccountRecord) -> MeOut:
    request.state.actor = Actor(account.name, account.role)
    (await change_of(request)).subject = account.name
    response.set_cookie(
        COOKIE,
        secret,
        max_age=int(SESSION_S),
        httponly=True,
        secure=request.url.scheme == "https",
        samesite="lax",  # a tag's link opened elsewhere finds its reader logged in; changes need our Origin
    )
    return MeOut(name=account.name, role=account.role, login=True)
