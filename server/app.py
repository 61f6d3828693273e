"""The application: settings in, everything made here and handed on; nothing is created at import."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI

from db.store import Store
from server import VERSION
from server.agents.process import ForkServer
from server.api import (
    accounts,
    alerts,
    base_map,
    best_map,
    evacuation,
    georeference,
    ground,
    health,
    history,
    locating,
    logs,
    maps,
    mission_report,
    missions,
    observations,
    orders,
    past_view,
    photos,
    pocket,
    reports,
    robot_tokens,
    robots,
    routes,
    sectors,
    session,
    stream,
    tags,
    victims,
    view,
)
from server.api import annotations as annotations_api
from server.api import audit as audit_api
from server.errors import add_error_handlers
from server.guard import Guard
from server.missions import Missions
from server.people.access import Access
from server.people.gate import gate
from server.people.welcome import welcome
from server.settings import Settings
from server.told import told_at
from web.mount import mount_web
from web.viser.scenes import Scenes


def create_app(settings: Settings) -> FastAPI:
    """Return the application. The database is opened when it starts, and missions are brought back.

    Raises (at start): DatabaseError where the database cannot be used.
    """
    scenes = Scenes()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        store = await Store.open(settings.database_target)
        forks = ForkServer()
        app.state.missions = Missions(store, forks, settings, scenes)
        app.state.access = access = Access(store, settings.login == "off", settings.robot_token)
        app.state.scenes = scenes
        app.state.started_s = time.monotonic()
        try:
            await access.restore()
            await welcome(access.accounts, settings)
            await forks.start()
            await app.state.missions.restore()
            yield
        finally:
            await app.state.missions.close()
            await forks.close()
            await scenes.close()
            await store.close()

    app = FastAPI(
        title="Waymark",
        version=VERSION,
        summary="Mission control for search and rescue where GPS and radio fail.",
        openapi_url="/api/v1/openapi.json",
        docs_url=None,  # their scripts would come from another server, and in the field there is none
        redoc_url=None,
        lifespan=lifespan,
    )
    add_error_handlers(app)
    app.add_middleware(
        Guard,
        max_body_bytes=settings.max_body_bytes,
        max_photo_bytes=settings.max_photo_bytes,
        loopback_only=settings.login == "off",
    )
    api = APIRouter(prefix="/api/v1")
    for module in (
        health,
        session,
        accounts,
        robot_tokens,
        audit_api,
        missions,
        logs,
        mission_report,
        history,
        robots,
        orders,
        routes,
        locating,
        pocket,
        reports,
        observations,
        tags,
        victims,
        alerts,
        evacuation,
        ground,
        annotations_api,
        photos,
        georeference,
        base_map,
        sectors,
        maps,
        best_map,
        stream,
        view,
        past_view,
    ):
        api.include_router(module.router)
    api.include_router(routes.where)
    app.include_router(api)
    mount_web(app, (scenes, gate), told_at=told_at)
    return app
