"""The OpenAPI document of the service (OpenAPI Specification 3.1.0), made of the tables by which requests are checked."""

import re

from ...blender_addon.edited_spectra import LONGEST_NAME, LONGEST_TEXT, MOST_COLUMNS
from ...blender_addon.scene_edits import NUMBERS
from ...engine import VERSION
from ...libraries.spectra import illuminant_names
from ..jobs import LONGEST_REQUEST
from ..orders import KINDS, schema_of

_PARAMETER = re.compile(r"{(\w+)(?::path)?}")

UPLOADS = ("/scenes", "/weather")
"""Ends of paths that take a file as their body, with ``?name=``."""


def describe_service(routes) -> dict:
    """Return the document.

    Parameters
    ----------
    routes : iterable of (str, str, str)    Method, path and what it is for.
    """
    paths: dict[str, dict] = {}
    for method, path, words in routes:
        plain = _PARAMETER.sub(r"{\1}", path)
        paths.setdefault(plain, {})[method.lower()] = _describe(method, path, words)
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "Lumenray",
            "version": VERSION,
            "description": "Lighting of scenes in real units, with a stated error",
        },
        "paths": paths,
        "components": {
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
            "schemas": {
                "Order": {"oneOf": [_order(kind) for kind in KINDS]},
                "Edits": _edits(),
                "RefusalError": {
                    "type": "object",
                    "properties": {"error": {"type": "string"}},
                    "required": ["error"],
                },
            },
        },
    }


def _describe(method: str, path: str, words: str) -> dict:
    parameters = [
        {"name": name, "in": "path", "required": True, "schema": {"type": "string"}}
        for name in _PARAMETER.findall(path)
    ]
    made = {"summary": words, "responses": _answers(method, path)}
    if path != "/openapi.json":
        made["security"] = [{"token": []}]
    if method in {"POST", "PUT"} and path.endswith(UPLOADS):
        text = {"type": "string", "minLength": 1}
        parameters.append({"name": "name", "in": "query", "required": True, "schema": text})
        made["requestBody"] = {"required": True, "content": {"application/octet-stream": {}}}
    if method == "POST" and path.endswith("/jobs"):
        text = {"type": "string", "minLength": 1, "maxLength": LONGEST_REQUEST}
        words = "A name of your own of this request: said again, it gives the same job"
        parameters.append(
            {"name": "Idempotency-Key", "in": "header", "description": words, "schema": text}
        )
        made["requestBody"] = _json("Order")
    if method == "PUT" and path.endswith("/edits"):
        made["requestBody"] = _json("Edits")
    if method == "GET" and path.endswith("/jobs"):
        parameters.append({"name": "before", "in": "query", "schema": {"type": "integer"}})
    return made | ({"parameters": parameters} if parameters else {})


def _answers(method: str, path: str) -> dict:
    good = {"DELETE": "204", "POST": "202" if path.endswith("/cancel") else "201"}.get(
        method, "200"
    )
    if path.endswith("/weather"):
        good = "204"
    refusal = {"application/json": {"schema": {"$ref": "#/components/schemas/RefusalError"}}}
    return {
        good: {"description": "done as asked"},
        "4XX": {"description": "refused; the answer says why", "content": refusal},
    }


def _json(name: str) -> dict:
    schema = {"$ref": f"#/components/schemas/{name}"}
    return {"required": True, "content": {"application/json": {"schema": schema}}}


def _order(kind: str) -> dict:
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {"kind": {"const": kind}, "options": schema_of(kind)},
        "required": ["kind"],
    }


def _edits() -> dict:
    light = {
        name: {"type": "number", "minimum": least, "maximum": most}
        for name, (least, most) in NUMBERS.items()
    }
    light |= {"spectrum": _spectrum(), "is_on": {"type": "boolean"}}
    names = {"type": "string"}
    either = {"not": {"required": ["temperature", "spectrum"]}}
    one = _object(light) | either
    material = {
        "oneOf": [
            names | {"description": "Of the library"},
            _object({"scene": names | {"description": "Of the scene itself"}}, "scene"),
        ]
    }
    return _object(
        {
            "lights": {"type": "object", "additionalProperties": one},
            "hidden": {"type": "array", "items": names},
            "materials": {"type": "object", "additionalProperties": material},
        }
    )


def _spectrum() -> dict:
    name = {"type": "string", "minLength": 1, "maxLength": LONGEST_NAME}
    words = "Content of a file of a spectrum: text, CSV, CGATS or IES TM-27"
    text = {"type": "string", "maxLength": LONGEST_TEXT, "description": words}
    column = {"type": "integer", "minimum": 1, "maximum": MOST_COLUMNS}
    return {
        "oneOf": [
            {"type": "string", "enum": list(illuminant_names())},
            _object({"file": name, "text": text, "column": column}, "file", "text"),
        ]
    }


def _object(properties: dict, *needed: str) -> dict:
    made = {"type": "object", "additionalProperties": False, "properties": properties}
    return made | ({"required": list(needed)} if needed else {})
