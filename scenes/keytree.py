"""Keys that a scene may have at each place: a walk through the JSON schema of its model along the given data."""


MEMBERS = ("kind", "law", "distribution")
"""Keys that say which of several tables one is."""


def real_keys(location, data):
    """Keys of an error's location, without pydantic's marks of union members."""
    path, here, after_kind = [], data, True
    for i, part in enumerate(location):
        table = here if isinstance(here, dict) else {}
        if isinstance(part, str) and part.startswith("<") and part not in table:
            continue  # the kind of the same table may follow
        if isinstance(part, str) and not after_kind and part in [table.get(name) for name in MEMBERS]:
            after_kind = True
            continue
        path.append(part)
        after_kind = False
        try:
            here = here[part]
        except (KeyError, IndexError, TypeError):
            here = None if i < len(location) - 1 else here
    return tuple(path)


def table_at(schema, path, data):
    """JSON schema of the value at `path`, in the union member that the data selects; {} if unknown."""
    node = _find(schema, path, data)
    if node is None:
        return {}
    about = {"description": node["description"]} if "description" in node else {}
    return {**resolved(schema, node), **about}


def kinds_at(schema, path, data):
    """Values of `kind` allowed by the union at `path`."""
    node = resolved(schema, _find(schema, path, data))
    return list(node.get("discriminator", {}).get("mapping", {}))


def places(schema):
    """{name: [path, ...]} of every key of a schema, shortest first; in a path 0 is an entry of a list, "NAME" a
    name."""
    found = {}
    _walk(schema, schema, (), frozenset(), found)
    return {name: sorted(paths, key=len) for name, paths in found.items()}


def _walk(schema, node, path, above, found):
    node = resolved(schema, node)
    if not isinstance(node, dict) or id(node) in above or len(path) > DEEPEST:
        return
    above = above | {id(node)}
    for member in (*node.get("oneOf", ()), *node.get("anyOf", ())):
        _walk(schema, member, path, above, found)
    if isinstance(node.get("items"), dict):
        _walk(schema, node["items"], (*path, 0), above, found)
    for more in (node.get("additionalProperties"), *node.get("patternProperties", {}).values()):
        if isinstance(more, dict):
            _walk(schema, more, (*path, "NAME"), above, found)
    for name, below in node.get("properties", {}).items():
        found.setdefault(name, {})[(*path, name)] = None
        _walk(schema, below, (*path, name), above, found)


def _find(schema, path, data):
    node, here = schema, data
    for part in path:
        node = _step(schema, node, part, here)
        if node is None:
            return None
        try:
            here = here[part]
        except (KeyError, IndexError, TypeError):
            here = None
    return _choose(schema, node, here)


def resolved(schema, node):
    """What a node refers to. Pydantic before 2.9 has a reference with a description in an `allOf` of one."""
    while node is not None and ("$ref" in node or len(node.get("allOf", ())) == 1):
        node = schema["$defs"][node["$ref"].rsplit("/", 1)[1]] if "$ref" in node else node["allOf"][0]
    return node


def _step(schema, node, part, here):
    node = resolved(schema, _choose(schema, node, here))
    if isinstance(part, int):
        return node.get("items")
    if part in node.get("properties", {}):
        return node["properties"][part]
    for more in (node.get("additionalProperties"), *node.get("patternProperties", {}).values()):
        if isinstance(more, dict):
            return more
    return None


def _choose(schema, node, here):
    """The union member that the value `here` belongs to."""
    plain = resolved(schema, node)
    members = plain.get("oneOf") or plain.get("anyOf")
    if not members:
        return node
    mapping = plain.get("discriminator", {}).get("mapping")
    if mapping:
        kind = here.get(plain["discriminator"]["propertyName"]) if isinstance(here, dict) else None
        return {"$ref": mapping[kind]} if isinstance(kind, str) and kind in mapping else node
    if not isinstance(here, dict):
        return node
    tables = [member for member in members if "properties" in resolved(schema, member)]
    tables += [m for m in members if "oneOf" in resolved(schema, m)]
    if not tables:
        return node

    def known(member):
        return len(here.keys() & resolved(schema, member).get("properties", {}))

    return _choose(schema, max(tables, key=known), here)


def given(schema, data):
    """(table, key, value) of every key that the data gives, table: the part of the schema that it belongs to."""
    yield from _given(schema, schema, data)


def _given(schema, node, here):
    node = resolved(schema, _choose(schema, node, here))
    if isinstance(here, list | tuple):
        for item in here:
            yield from _given(schema, node.get("items") or {}, item)
    elif isinstance(here, dict):
        for key, value in here.items():
            if key in node.get("properties", {}):
                yield node, key, value
            below = _step(schema, node, key, here)
            if isinstance(below, dict):
                yield from _given(schema, below, value)


DEEPEST = 6
"""Largest depth of nested tables that `all_keys` follows."""


def all_keys(schema, data):
    """(path, value, description) of every key that a scene with this data may have, set or not; value: None where it is
    not set. A table that is not set counts as a key, with what it may hold below it; of a list, the entries there are.
    """
    yield from _keys_below(schema, (), data, data)


def _keys_below(schema, path, here, data):
    if len(path) > 2 * DEEPEST:
        return
    if isinstance(here, list | tuple):
        for i, item in enumerate(here):
            if isinstance(item, dict):
                yield from _keys_below(schema, (*path, i), item, data)
        return
    known = table_at(schema, path, data)
    names = dict.fromkeys([*(here or {}), *known.get("properties", {})])
    for name in names:
        value = (here or {}).get(name)
        below = (*path, name)
        if isinstance(value, dict) or (isinstance(value, list | tuple) and value and isinstance(value[0], dict)):
            yield from _keys_below(schema, below, value, data)
            continue
        about = table_at(schema, below, data)
        yield below, value, about.get("description", "")
        if value is None and len(path) < DEEPEST:
            yield from _unset(schema, _table_of(schema, about), below)


def _unset(schema, table, path):
    """Keys of a table that is not given."""
    for name, node in (table or {}).get("properties", {}).items():
        yield (*path, name), None, resolved(schema, node).get("description", "")


def _table_of(schema, node):
    """The only table that a node allows; None if it allows several kinds."""
    members = [resolved(schema, one) for one in node.get("anyOf", [node])]
    tables = [one for one in members if "properties" in one]
    return tables[0] if len(tables) == 1 else None


def values_at(schema, path, data):
    """Allowed words of the key at `path`, if it is an enumeration."""
    node = table_at(schema, path, data)
    members = [resolved(schema, one) for one in node.get("anyOf", node.get("oneOf", [node]))]
    found = []
    for one in members:
        found += one.get("enum", [one["const"]] if "const" in one else [])
        found += [True, False] if one.get("type") == "boolean" else []
    return [value for value in found if value is not None]
