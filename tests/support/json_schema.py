# SPDX-License-Identifier: GPL-3.0-or-later
"""JSON against a schema (draft 2020-12), by the package jsonschema."""
import json
from pathlib import Path


def validate(data, schema_path):
    """A list of what is wrong, each with its place in the data; empty: nothing. A schema that is none itself is an error."""
    from jsonschema import Draft202012Validator  # tools/quickstart deps installs it
    schema = json.loads(Path(schema_path).read_text())
    Draft202012Validator.check_schema(schema)
    return [f"{error.json_path}: {error.message}" for error in Draft202012Validator(schema).iter_errors(data)]
