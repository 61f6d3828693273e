"""The OpenAPI document: complete, and its examples are true."""

import re
from uuid import uuid4

import pytest

from server.app import create_app
from server.settings import Settings

METHODS = ("get", "put", "post", "patch", "delete")


@pytest.fixture(scope="module")
def document(control):
    return control.call("GET", "/openapi.json").json()


def operations(document):
    return [
        (method, path, item[method])
        for path, item in document["paths"].items()
        for method in METHODS
        if method in item
    ]


def test_every_operation_is_described(document):
    found = operations(document)
    assert len(found) >= 60
    for method, path, operation in found:
        assert path.startswith("/api/v1/"), path
        assert len(operation["summary"]) > 3, (method, path)
        assert operation["description"].endswith("."), (method, path)
        assert re.fullmatch(r"[a-z]+(_[a-z]+)+", operation["operationId"]), operation["operationId"]
        assert operation["tags"], (method, path)
    ids = [operation["operationId"] for _, _, operation in found]
    assert len(set(ids)) == len(ids)


def test_every_refusal_has_the_one_form(document):
    error = {"$ref": "#/components/schemas/ErrorWire"}
    for method, path, operation in operations(document):
        for status, response in operation["responses"].items():
            if int(status) >= 400:
                assert response["content"]["application/json"]["schema"] == error, (method, path, status)
        if "{" in path:
            assert "404" in operation["responses"], path
    assert "HTTPValidationError" not in document["components"]["schemas"]


def test_every_property_of_a_request_is_bounded_or_described(document):
    """No text, list or number that a client may make as long as it likes."""
    schemas = document["components"]["schemas"]
    bounds = {"enum", "const", "maxLength", "maximum", "exclusiveMaximum", "format", "$ref", "maxItems"}
    for name, schema in schemas.items():
        if not (name.endswith("In") or name == "ObservationIn"):
            continue
        for field, item in schema["properties"].items():
            kinds = item.get("anyOf") or item.get("oneOf") or [item]
            for kind in kinds:
                free = kind.get("type") in ("string", "number", "integer", "array")
                assert not free or bounds & kind.keys(), (name, field)


def test_the_examples_are_accepted(control, document):
    """Each example of a request body, sent as it stands to a mission that has what it speaks of."""
    mission = control.open()
    mission.register("r1")
    sent = 0
    for method, path, operation in operations(document):
        reference = (
            operation.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema")
        )
        if reference is None:
            continue
        schema = document["components"]["schemas"][reference["$ref"].rsplit("/", 1)[1]]
        assert schema["examples"], (method, path)
        for example in schema["examples"]:
            address = path.format(
                mission_id=mission.mission_id,
                robot_id="r1",
                victim_id="v1",
                alert_id="hot:N1",
                annotation_id=uuid4(),
                sector_id=uuid4(),
                report_id=uuid4(),
                account_id="a1",
                token_id="t1",
            ).removeprefix("/api/v1")
            response = control.call(method.upper(), address, example)
            # nobody has seen a victim yet, nor is it hot anywhere; and nobody has an account, a link or a map
            nowhere = {"{victim_id}", "{alert_id}", "{account_id}"} & set(path.split("/"))
            refused = {"log_in": 401, "join_by_link": 403, "copy_base_map": 409, "locate_by_radio": 409}.get(
                operation["operationId"]
            )
            expected = (404,) if nowhere else (200, 201) if refused is None else (refused,)
            assert response.status_code in expected, (method, path, response.text)
            sent += 1
    assert sent >= 9


def test_the_document_needs_no_server(tmp_path):
    """Nothing is created or opened before the application starts."""
    app = create_app(Settings(data_dir=tmp_path / "none"))
    assert app.openapi()["info"]["title"] == "Waymark"
    assert not (tmp_path / "none").exists()


def test_unknown_addresses_and_methods_have_the_form_too(line):
    assert line.refused("GET", "/nothing") == (404, "unknown_address", None)
    assert line.refused("DELETE", "/robots")[:2] == (405, "wrong_method")
