# SPDX-License-Identifier: GPL-3.0-or-later
"""The validator of the tests finds what breaks a schema, and the schema of msm_diagnose uses only what it knows."""
import json
import tempfile
import unittest
from pathlib import Path

from json_schema import CHECKS, NOTES, validate

SOURCE = Path(__file__).resolve().parents[3]
ONE = {"type": "object", "properties": {"kind": {"enum": ["a", "b"]}, "n": {"type": "integer", "minimum": 1, "maximum": 5},
                                        "x": {"type": ["number", "null"]}, "list": {"$ref": "#/$defs/list"}},
       "required": ["kind"], "additionalProperties": False,
       "if": {"properties": {"kind": {"const": "a"}}}, "then": {"required": ["n"]}}
SCHEMA = {"$defs": {"one": ONE, "list": {"type": "array", "items": {"type": "string"}, "minItems": 1, "maxItems": 2},
                    "other": {"type": "object", "properties": {"kind": {"const": "c"}}, "required": ["kind"]}},
          "oneOf": [{"$ref": "#/$defs/one"}, {"$ref": "#/$defs/other"}]}
RIGHT = [{"kind": "a", "n": 1}, {"kind": "b"}, {"kind": "a", "n": 5, "x": None, "list": ["p", "q"]}, {"kind": "b", "x": 1},
         {"kind": "c", "more": 1}]
WRONG = [{"kind": "a"}, {"kind": "b", "n": 0}, {"kind": "b", "n": 6}, {"kind": "b", "n": 1.5}, {"kind": "b", "n": True},
         {"kind": "b", "x": "1"}, {"kind": "b", "list": []}, {"kind": "b", "list": ["p", "q", "r"]},
         {"kind": "b", "list": ["p", 1]}, {"kind": "b", "more": 1}, {"kind": "d"}, {"n": 1}, [], None]


class Schema(unittest.TestCase):
    def problems(self, data, schema=SCHEMA):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "schema.json")
            path.write_text(json.dumps(schema))
            return validate(data, path)

    def test_data(self):
        for data in RIGHT:
            self.assertEqual(self.problems(data), [], data)
        for data in WRONG:
            self.assertTrue(self.problems(data), data)

    def test_unknown_keyword(self):
        with self.assertRaises(ValueError):
            self.problems("text", {"pattern": "x"})

    def test_diagnosis(self):
        """Every keyword in every branch, also of those that no data has come by, is known, and every reference leads
        somewhere."""
        schema = json.loads((SOURCE / "docs/formats/diagnosis.schema.json").read_text())
        pending = [schema, *schema["$defs"].values()]
        while pending:
            part = pending.pop()
            self.assertLessEqual(set(part), set(CHECKS) | NOTES)
            if "$ref" in part:
                self.assertIn(part["$ref"].removeprefix("#/$defs/"), schema["$defs"])
            for name in "items", "if", "then", "else":
                pending += [part[name]] if name in part else []
            pending += [*part.get("properties", {}).values(), *part.get("oneOf", [])]


if __name__ == "__main__":
    unittest.main()
