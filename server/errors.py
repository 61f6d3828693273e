"""Refusals: every error that leaves the server is ``{"error": {"code", "message", "field"}}``, made here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from db.errors import DatabaseError

log = structlog.get_logger()

_UNION_TAGS = {"wheels", "distance_turn", "displacement"}  # pydantic names the chosen kind in the path


class ApiError(Exception):
    """A request that cannot be done: what is wrong, what to do, and which field it is about."""

    def __init__(
        self, status: int, code: str, message: str, field: str | None = None, retry_after_s: int | None = None
    ) -> None:
        super().__init__(message)
        self.status = status
        self.code = code
        self.message = message
        self.field = field
        self.retry_after_s = retry_after_s


def unknown(noun: str, name: str) -> ApiError:
    """Return the error for a name in the address that nothing has."""
    return ApiError(404, f"unknown_{noun}", f"There is no {noun} {name!r}; check the address.")


def error_response(
    status: int, code: str, message: str, field: str | None = None, headers: dict[str, str] | None = None
) -> JSONResponse:
    """Return an error as it stands on the wire."""
    body = {"error": {"code": code, "message": message, "field": field}}
    return JSONResponse(body, status_code=status, headers=headers)


def add_error_handlers(app: FastAPI) -> None:
    """Give every error of the application its one form."""

    async def refused(_: Request, error: ApiError) -> JSONResponse:
        headers = {} if error.retry_after_s is None else {"Retry-After": str(error.retry_after_s)}
        return error_response(error.status, error.code, error.message, error.field, headers)

    async def invalid(_: Request, error: RequestValidationError) -> JSONResponse:
        first = error.errors()[0]
        if first["type"] == "json_invalid":
            return error_response(422, "invalid_json", f"The body is not JSON: {first['ctx']['error']}.")
        field = field_name(first["loc"])
        message = first["msg"].removeprefix("Value error, ")
        return error_response(422, "invalid", f"{field or 'The body'}: {message}.".replace("..", "."), field)

    async def http(_: Request, error: HTTPException) -> JSONResponse:
        if error.status_code == 400 and "parsing the body" in str(error.detail):
            text = "The body cannot be read as JSON: it is nested too deeply or holds a number too long."
            return error_response(422, "invalid_json", text)
        known = {404: "unknown_address", 405: "wrong_method", 413: "too_large"}
        code = known.get(error.status_code, "refused")
        detail = str(error.detail)
        message = detail if detail.endswith(".") else f"{detail}; check the address and the method."
        return error_response(error.status_code, code, message, headers=dict(error.headers or {}))

    async def database(_: Request, error: DatabaseError) -> JSONResponse:
        log.error("database", reason=str(error))
        return error_response(503, "database", str(error), headers={"Retry-After": "1"})

    async def bug(_: Request, error: Exception) -> JSONResponse:
        return error_response(500, "internal", "The server has a fault; it is in the server's log.")

    app.add_exception_handler(ApiError, refused)  # type: ignore[arg-type]
    app.add_exception_handler(RequestValidationError, invalid)  # type: ignore[arg-type]
    app.add_exception_handler(HTTPException, http)  # type: ignore[arg-type]
    app.add_exception_handler(DatabaseError, database)  # type: ignore[arg-type]
    app.add_exception_handler(Exception, bug)


def field_name(location: Sequence[Any]) -> str | None:
    """Return ``observations.3.imu.yaw_rad`` for the place at which validation failed.

    None for the whole body.
    """
    parts = [str(part) for part in location if str(part) not in _UNION_TAGS]
    parts = parts[1:] if parts and parts[0] in ("body", "query", "path") else parts
    return ".".join(parts) or None
