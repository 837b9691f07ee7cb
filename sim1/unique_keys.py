"""Reading of YAML in which no mapping has a key twice."""

from collections.abc import Hashable

import yaml


class UniqueKeys(yaml.SafeLoader):
    """PyYAML keeps the last of two equal keys and says nothing."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        seen = set()
        for name, _ in node.value:
            key = self.construct_object(name, deep=True)
            if isinstance(key, Hashable) and key in seen and name.tag != "tag:yaml.org,2002:merge":
                raise yaml.constructor.ConstructorError(None, None, f"the key {key!r} occurs twice", name.start_mark)
            seen.add(key if isinstance(key, Hashable) else id(name))
        return super().construct_mapping(node, deep)
