"""The JSON objects that commands print, checked against the schema in the docs."""

import json
from functools import cache
from pathlib import Path

import jsonschema

SCHEMA = Path(__file__).parents[1] / "docs" / "answer.schema.json"


@cache
def validator():
    schema = json.loads(SCHEMA.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def answer(printed):
    """What a command printed, as the schema wants it: an object on one line."""
    assert printed.count("\n") == 1
    content = json.loads(printed)
    validator().validate(content)
    return content


def result(printed):
    """The same with the members of its result beside the others."""
    content = answer(printed)
    return content["result"] | content
