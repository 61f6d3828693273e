"""Accounts, and links by which people join."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from fastapi import APIRouter

from db.people_records import AccountRecord
from server.api.common import ERRORS, Commander, TheAccess, TheChange
from server.people.audit import AuditedRoute
from server.schemas.people import AccountIn, AccountOut, AccountsOut, LinkIn, LinkOut

router = APIRouter(tags=["people"], responses=ERRORS, route_class=AuditedRoute)


@router.get("/accounts", summary="All accounts", operation_id="get_accounts")
async def get_accounts(access: TheAccess, by: Commander) -> AccountsOut:
    """Return every account, oldest first."""
    return AccountsOut(accounts=[AccountOut(**_value(account)) for account in access.accounts.all()])


@router.patch("/accounts/{account_id}", summary="Change an account", operation_id="change_account")
async def change_account(
    account_id: str, body: AccountIn, access: TheAccess, by: Commander, change: TheChange
) -> AccountOut:
    """Give another role, shut out or let in, or set a new password."""
    before, after = await access.accounts.change(account_id, body.role, body.disabled, body.password)
    change.subject = after.name
    change.before, change.after = _value(before), _value(after)
    return AccountOut(**_value(after))


@router.post("/links", status_code=201, summary="Invite somebody", operation_id="make_link")
async def make_link(body: LinkIn, access: TheAccess, by: Commander, change: TheChange) -> LinkOut:
    """Make a link with which one person joins, within a day."""
    secret, link = await access.accounts.make_link(body.role, by.name)
    change.subject = body.role
    return LinkOut(path=f"/join#{secret}", role=link.role, expires_unix_s=link.expires_unix_s)


def _value(account: AccountRecord) -> dict[str, Any]:
    value = asdict(account)
    del value["password"]
    return value
