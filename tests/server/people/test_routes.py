"""What holds for every route there is: somebody is asked for, and no change goes unnoted."""

import pkgutil
from importlib import import_module

from fastapi import APIRouter
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute

import server.api
from server.api.common import Needs
from server.people.audit import AuditedRoute

FOR_EVERYBODY = {"get_health", "get_session", "log_in", "join_by_link"}
KEPT_ELSEWHERE = {"post_observations"}  # the mission's log is their log
QUESTIONS = {"locate_by_radio"}  # by POST, as they have a body


def routes():
    for module in pkgutil.iter_modules(server.api.__path__):
        for router in vars(import_module(f"server.api.{module.name}")).values():
            if isinstance(router, APIRouter):
                yield from (route for route in router.routes if isinstance(route, APIRoute))


def roles(dependant: Dependant):
    found = [dependant.call.role] if isinstance(dependant.call, Needs) else []
    for inner in dependant.dependencies:
        found += roles(inner)
    return found


def test_every_route_asks_who_it_is():
    found = {route.name: roles(route.dependant) for route in routes()}
    assert len(found) > 25
    assert {name for name, needed in found.items() if not needed} == FOR_EVERYBODY


def test_every_change_asks_for_more_than_looking():
    lax = {
        route.name
        for route in routes()
        if not route.methods <= {"GET", "HEAD"} and set(roles(route.dependant)) <= {"viewer"}
    }
    help_ = {"call_mayday", "end_mayday", "acknowledge_evacuation", "put_report"}
    assert lax - QUESTIONS == {"log_in", "join_by_link", "log_out"} | help_


def test_who_may_lead_a_mission():
    """Who may pause may start again; what ends a mission, or brings it back, is for commanders."""
    needed = {route.name: set(roles(route.dependant)) - {"viewer"} for route in routes()}
    may = {
        "responder": {"post_photo", "put_annotation", "stop_robots"},
        "operator": {
            "create_mission", "start_mission", "pause_mission", "put_sector", "explore_sector",
            "delete_photo", "put_georeference", "put_base_map", "copy_base_map",
        },
        "commander": {"close_mission", "archive_mission", "reopen_mission", "begin_period", "end_period"},
    }  # fmt: skip
    for role, names in may.items():
        assert {name: needed[name] for name in names} == {name: {role} for name in names}


def test_every_change_goes_through_the_audit_log():
    unnoted = {
        route.name
        for route in routes()
        if not route.methods <= {"GET", "HEAD"} and not isinstance(route, AuditedRoute)
    }
    assert unnoted == KEPT_ELSEWHERE | QUESTIONS
