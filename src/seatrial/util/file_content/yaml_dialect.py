# SPDX-License-Identifier: MIT
"""The YAML that is read and written: 1.2's words and numbers, unique keys, short lists on one line."""

import re
from typing import Any

import yaml

DIGITS = 10  # significant digits of numbers in YAML files


class Loader(yaml.CSafeLoader if hasattr(yaml, "CSafeLoader") else yaml.SafeLoader):  # type: ignore[misc]
    """YAML 1.2's booleans and numbers (1e-3 is a number, `on` is a word); keys are unique."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Refuse a duplicate key."""
        seen: set[Any] = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, (list, dict)):
                raise yaml.constructor.ConstructorError(
                    None, None, "a key must be a word", key_node.start_mark
                )
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"key '{key}' stands twice", key_node.start_mark
                )
            seen.add(key)
        return dict(super().construct_mapping(node, deep))


Loader.yaml_implicit_resolvers = {
    first: [
        (tag, pattern)
        for tag, pattern in rules
        if not tag.endswith((":bool", ":int", ":float", ":timestamp"))
    ]
    for first, rules in Loader.yaml_implicit_resolvers.items()
}
Loader.add_implicit_resolver(
    "tag:yaml.org,2002:bool", re.compile(r"^(?:true|True|false|False)$"), list("tTfF")
)
_INT = (  # 01500 is 1500: YAML 1.1's 832 is octal, which nobody means
    "tag:yaml.org,2002:int",
    re.compile(r"^[-+]?\d{1,300}$|^0o[0-7]{1,100}$|^0x[\da-fA-F]{1,100}$"),
    list("-+0123456789"),
)
_FLOAT = (
    "tag:yaml.org,2002:float",
    re.compile(
        r"^[-+]?(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?$|^[-+]?\.(?:inf|Inf)$|^\.(?:nan|NaN)$"
    ),
    list("-+.0123456789"),
)
Loader.add_implicit_resolver(*_INT)
Loader.add_implicit_resolver(*_FLOAT)


def _whole_number(loader: Loader, node: yaml.ScalarNode) -> int:
    """A whole number of YAML 1.2."""
    text = str(loader.construct_scalar(node))
    return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))


Loader.add_constructor("tag:yaml.org,2002:int", _whole_number)


class Dumper(yaml.SafeDumper):
    """Numbers in `DIGITS` digits; order and line breaks kept."""


def _flow_list(dumper: yaml.SafeDumper, data: list[Any]) -> yaml.Node:
    short = all(isinstance(x, (int, float)) or (isinstance(x, str) and " " not in x) for x in data)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=short)


def _flow_mapping(dumper: yaml.SafeDumper, data: dict[str, Any]) -> yaml.Node:
    short = len(data) <= 4 and not any(isinstance(x, (list, tuple, dict)) for x in data.values())
    return dumper.represent_mapping("tag:yaml.org,2002:map", data, flow_style=short)


def _float(dumper: yaml.SafeDumper, data: float) -> yaml.Node:
    text = f"{data:.{DIGITS}g}"
    if "." not in text and "n" not in text:  # with a point: else YAML 1.1 reads 1e-05 as text
        number, e, exponent = text.partition("e")
        text = f"{number}.0{e}{exponent}"
    text = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}.get(text, text)
    return dumper.represent_scalar("tag:yaml.org,2002:float", text)


def _text(dumper: yaml.SafeDumper, data: str) -> yaml.Node:
    """A string in double quotes where it has line breaks, which become spaces otherwise."""
    style = None if data.isprintable() else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", data, style=style)


Dumper.add_implicit_resolver(*_INT)
Dumper.add_implicit_resolver(*_FLOAT)  # a word that reads as a number is quoted
Dumper.add_representer(list, _flow_list)
Dumper.add_representer(tuple, lambda dumper, data: _flow_list(dumper, list(data)))
Dumper.add_representer(dict, _flow_mapping)
Dumper.add_representer(float, _float)
Dumper.add_representer(str, _text)
