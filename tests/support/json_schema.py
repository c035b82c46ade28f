# SPDX-License-Identifier: GPL-3.0-or-later
"""Validates JSON against a schema (draft 2020-12), as far as the schemas of this repository go; a keyword that is not known
is an error of the schema. Only the standard library is needed."""
import json
from pathlib import Path

NOTES = {"$schema", "$defs", "title", "description"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), "number": (int, float),
         "integer": int}


def validate(data, schema_path):
    """A list of what is wrong, each with its place in the data; empty: nothing."""
    schema = json.loads(Path(schema_path).read_text())
    return list(_problems(data, schema, schema, "$"))


def _is(data, name):
    if isinstance(data, bool):  # to Python a kind of integer
        return name == "boolean"
    return isinstance(data, TYPES[name])


def _same(a, b):
    return a == b and isinstance(a, bool) == isinstance(b, bool)


def _problems(data, schema, root, place):
    for keyword in schema:
        if keyword not in NOTES:
            if keyword not in CHECKS:
                raise ValueError(f"{place}: the schema's keyword {keyword} is not known")
            yield from CHECKS[keyword](data, schema, root, place)


def _ref(data, schema, root, place):
    target = root
    for name in schema["$ref"].removeprefix("#/").split("/"):
        target = target[name]
    yield from _problems(data, target, root, place)


def _type(data, schema, root, place):
    names = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    if not any(_is(data, name) for name in names):
        yield f"{place} is {data!r:.60}, not of type {' or '.join(names)}"


def _const(data, schema, root, place):
    if not _same(data, schema["const"]):
        yield f"{place} is {data!r:.60}, not {schema['const']!r}"


def _enum(data, schema, root, place):
    if not any(_same(data, value) for value in schema["enum"]):
        yield f"{place} is {data!r:.60}, not one of {schema['enum']}"


def _minimum(data, schema, root, place):
    if _is(data, "number") and data < schema["minimum"]:
        yield f"{place} is {data}, less than {schema['minimum']}"


def _maximum(data, schema, root, place):
    if _is(data, "number") and data > schema["maximum"]:
        yield f"{place} is {data}, more than {schema['maximum']}"


def _min_items(data, schema, root, place):
    if isinstance(data, list) and len(data) < schema["minItems"]:
        yield f"{place} has {len(data)} items, fewer than {schema['minItems']}"


def _max_items(data, schema, root, place):
    if isinstance(data, list) and len(data) > schema["maxItems"]:
        yield f"{place} has {len(data)} items, more than {schema['maxItems']}"


def _items(data, schema, root, place):
    if isinstance(data, list):
        for number, one in enumerate(data):
            yield from _problems(one, schema["items"], root, f"{place}[{number}]")


def _properties(data, schema, root, place):
    if isinstance(data, dict):
        for name, part in schema["properties"].items():
            if name in data:
                yield from _problems(data[name], part, root, f"{place}.{name}")


def _required(data, schema, root, place):
    if isinstance(data, dict):
        for name in schema["required"]:
            if name not in data:
                yield f"{place} lacks {name}"


def _additional(data, schema, root, place):
    if schema["additionalProperties"] is not False:
        raise ValueError("additionalProperties can be false only")
    if isinstance(data, dict):
        for name in data:
            if name not in schema.get("properties", {}):
                yield f"{place} has {name}, which is not known"


def _one_of(data, schema, root, place):
    found = [list(_problems(data, part, root, place)) for part in schema["oneOf"]]
    if sum(not problems for problems in found) != 1:
        yield min(found, key=len)[0] if all(found) else f"{place} is of more than one kind"


def _if(data, schema, root, place):
    is_so = not list(_problems(data, schema["if"], root, place))
    part = schema.get("then" if is_so else "else")
    if part:
        yield from _problems(data, part, root, place)


def _nothing(data, schema, root, place):
    yield from ()


CHECKS = {"$ref": _ref, "type": _type, "const": _const, "enum": _enum, "minimum": _minimum, "maximum": _maximum,
          "minItems": _min_items, "maxItems": _max_items, "items": _items, "properties": _properties,
          "required": _required, "additionalProperties": _additional, "oneOf": _one_of, "if": _if, "then": _nothing,
          "else": _nothing}
