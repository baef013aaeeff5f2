"""Values of JSON held against a schema: the first fault as one sentence.

Of JSON Schema (draft 2020-12) those words are known that our schemas use; another one is an error of ours, as a rule that is
silently left out would let anything pass.
"""

import math

_TYPES = {
    "object": (dict, "an object in braces"),
    "array": (list, "a list in brackets"),
    "string": (str, "a text"),
    "number": ((int, float), "a number"),
    "boolean": (bool, "true or false"),
}

_KNOWN = {
    "$schema", "$defs", "$ref", "title", "description", "type", "const", "enum", "minimum", "maximum", "maxLength",
    "minItems", "maxItems", "items", "properties", "required", "additionalProperties", "oneOf", "anyOf",
}  # fmt: skip


class SchemaError(Exception):
    """A value breaks its schema; the message says where, what was found and what was expected."""


def check_value(value, schema: dict) -> None:
    """Hold a value against a schema.

    ``minimum``, ``maximum`` and so on count for values of their type alone, as the standard says; ``oneOf`` and ``anyOf``
    are known of objects that have the properties of exactly one, or of some, of several lists.

    Raises
    ------
    SchemaError    The first thing that is wrong.
    """
    _check(value, schema, schema, "")


def _check(value, schema: dict, root: dict, place: str) -> None:
    unknown = schema.keys() - _KNOWN
    if unknown:
        raise ValueError(f"the schema has '{unknown.pop()}', which is not known")
    if "$ref" in schema:
        target = root
        for step in schema["$ref"].removeprefix("#/").split("/"):
            target = target[step]
        _check(value, target, root, place)
    here = place or "the description"
    types = schema.get("type", [])
    types = [types] if isinstance(types, str) else types
    if types and not any(_is_of(value, each) for each in types):
        expected = " or ".join(_TYPES[each][1] for each in types)
        raise SchemaError(f"{here} is {_shown(value)}, expected {expected}")
    if "const" in schema and value != schema["const"]:
        raise SchemaError(f"{here} is {_shown(value)}, expected {schema['const']!r}")
    if "enum" in schema and value not in schema["enum"]:
        raise SchemaError(f"{here} is {_shown(value)}, expected {' or '.join(schema['enum'])}")
    if isinstance(value, dict):
        _check_object(value, schema, root, place)
    elif isinstance(value, list):
        _check_list(value, schema, root, here)
    elif isinstance(value, str):
        if len(value) > schema.get("maxLength", math.inf):
            raise SchemaError(
                f"{here} has {len(value)} characters, expected {schema['maxLength']} at most"
            )
    elif _is_of(value, "number"):
        low, high = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
        if not low <= value <= high:
            raise SchemaError(f"{here} is {value:g}, expected {low:g} to {high:g}")


def _check_object(value: dict, schema: dict, root: dict, place: str) -> None:
    here, own = place or "the description", schema.get("properties", {})
    if schema.get("additionalProperties") is False:
        for name in value:
            if name not in own:
                raise SchemaError(f"{here} has {_shown(name)}, expected {', '.join(own)}")
    for name in schema.get("required", []):
        if name not in value:
            raise SchemaError(f"{here} lacks '{name}'")
    for word, most in (("oneOf", 1), ("anyOf", math.inf)):
        ways = [each["required"] for each in schema.get(word, [])]
        if ways and not 1 <= sum(all(name in value for name in way) for way in ways) <= most:
            known = {name for way in ways for name in way}
            there = " and ".join(f"'{name}'" for name in value if name in known) or "none of them"
            choice = ", or ".join(" and ".join(f"'{name}'" for name in way) for way in ways)
            raise SchemaError(f"{here} has {there}, expected {choice}")
    others = schema.get("additionalProperties")
    for name, each in value.items():
        if name in own or isinstance(others, dict):
            _check(each, own.get(name, others), root, f"{place}.{name}" if place else name)


def _check_list(value: list, schema: dict, root: dict, here: str) -> None:
    least, most = schema.get("minItems", 0), schema.get("maxItems", math.inf)
    if not least <= len(value) <= most:
        wanted = f"{least}" if least == most else f"{least} to {most}"
        raise SchemaError(f"{here} has {len(value)} entries, expected {wanted}")
    for k, each in enumerate(value):
        _check(each, schema.get("items", {}), root, f"{here}[{k}]")


def _is_of(value, kind: str) -> bool:
    if kind == "number":
        # An int may have thousands of digits and be no float.
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and -1e300 < value < 1e300
    return isinstance(value, _TYPES[kind][0])


def _shown(value) -> str:
    text = (
        repr(value)
        if not isinstance(value, dict | list)
        else _TYPES["object" if isinstance(value, dict) else "array"][1]
    )
    return text if len(text) <= 40 else text[:37] + "…"
