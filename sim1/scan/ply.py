"""Strict PLY reader and a small binary writer: vertices with any scalar properties, and triangles.

trimesh reads PLY too, but takes a truncated file for a shorter one and drops the properties of point clouds.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.stage import BadInput

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_POLYGON = ("vertex_indices", "vertex_index")
_ORDER = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": None}


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    scalars: tuple[tuple[str, str], ...]  # name, numpy type
    lists: tuple[tuple[str, str, str], ...]  # name, numpy types of the count and of the items


def read_ply(path: Path) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Vertex properties by name, each (n,), and triangles (f, 3) int32 (polygons are split into fans).

    Raises:
        BadInput: not a PLY file, truncated, or of a kind that is not supported.
    """
    data = path.read_bytes()
    order, elements, start = _header(path, data)
    vertex: dict[str, np.ndarray] = {}
    faces = np.zeros((0, 3), np.int32)
    tokens = data[start:].split() if order is None else []
    for element in elements:
        if order is None:
            columns, lists, used = _read_ascii(path, element, tokens)
            tokens = tokens[used:]
        else:
            columns, lists, start = _read_binary(path, element, data, start, order)
        if element.name == "vertex":
            vertex = columns
        elif element.name == "face":
            faces = _fans(lists)
    if not {"x", "y", "z"} <= set(vertex):
        raise BadInput(f"{path}: no vertex element with x, y, z; is this a PLY point cloud or mesh?")
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertex["x"])):
        raise BadInput(
            f"{path}: a face names vertex {faces.max()}, but there are {len(vertex['x'])}; export the file again"
        )
    return vertex, faces


def write_ply(
    path: Path, vertex: dict[str, np.ndarray], faces: np.ndarray | None = None, comments: tuple[str, ...] = ()
) -> None:
    """Write binary little-endian PLY; property types are those of the arrays."""
    names = {
        "i1": "char",
        "u1": "uchar",
        "i2": "short",
        "u2": "ushort",
        "i4": "int",
        "u4": "uint",
        "f4": "float",
        "f8": "double",
    }
    count = len(next(iter(vertex.values())))
    table = np.empty(count, [(name, array.dtype.newbyteorder("<")) for name, array in vertex.items()])
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {text}" for text in comments),
        f"element vertex {count}",
    ]
    for name, array in vertex.items():
        table[name] = array
        lines.append(f"property {names[array.dtype.str[1:]]} {name}")
    body = table.tobytes()
    if faces is not None:
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        polygons = np.empty(len(faces), [("n", "u1"), ("i", "<i4", (3,))])
        polygons["n"], polygons["i"] = 3, faces
        body += polygons.tobytes()
    path.write_bytes("\n".join([*lines, "end_header", ""]).encode() + body)


def _header(path: Path, data: bytes) -> tuple[str | None, list[_Element], int]:
    if not data.startswith(b"ply"):
        raise BadInput(
            f"{path}: does not start with 'ply'; {'the file is empty' if not data else 'it is not a PLY file'}"
        )
    end = data.find(b"end_header")
    if end < 0:
        raise BadInput(f"{path}: the PLY header has no end_header line; the file is truncated, export it again")
    order, elements = "", []
    for number, line in enumerate(data[:end].decode("ascii", "replace").splitlines(), 1):
        words = line.split()
        try:
            match words:
                case ["format", kind, *_]:
                    order = kind
                case ["element", name, count]:
                    elements.append(_Element(name, int(count), (), ()))
                case ["property", "list", count_type, item_type, name]:
                    last = elements.pop()
                    lists = (*last.lists, (name, _TYPES[count_type], _TYPES[item_type]))
                    elements.append(_Element(last.name, last.count, last.scalars, lists))
                case ["property", kind, name]:
                    last = elements.pop()
                    elements.append(_Element(last.name, last.count, (*last.scalars, (name, _TYPES[kind])), last.lists))
        except (KeyError, ValueError, IndexError) as error:
            raise BadInput(f"{path}: line {number} of the header, {line!r}, is not valid PLY") from error
    if order not in _ORDER:
        raise BadInput(f"{path}: PLY format is {order!r}; expected one of {', '.join(_ORDER)}")
    return _ORDER[order], elements, data.index(b"\n", end) + 1


def _truncated(path: Path, element: _Element, found: int) -> BadInput:
    return BadInput(
        f"{path}: truncated: {found} of {element.count} entries of element {element.name!r}; export or copy it again"
    )


def _read_ascii(path: Path, element: _Element, tokens: list[bytes]) -> tuple[dict, list, int]:
    try:
        if not element.lists:
            width = len(element.scalars)
            if len(tokens) < element.count * width:
                raise _truncated(path, element, len(tokens) // max(width, 1))
            table = np.array(tokens[: element.count * width]).astype(float).reshape(element.count, width)
            columns = {name: table[:, k].astype(kind) for k, (name, kind) in enumerate(element.scalars)}
            return columns, [], element.count * width
        lists, place = [], 0
        for found in range(element.count):
            place += len(element.scalars)
            for name, _, _ in element.lists:
                size = int(tokens[place]) if place < len(tokens) else len(tokens)
                if place + size >= len(tokens):
                    raise _truncated(path, element, found)
                if name in _POLYGON:
                    lists.append(np.array(tokens[place + 1 : place + 1 + size]).astype(np.int64))
                place += 1 + size
        return {}, lists, place
    except ValueError as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(f"{path}: element {element.name!r} holds something that is not a number ({error})") from error


def _read_binary(path: Path, element: _Element, data: bytes, start: int, order: str) -> tuple[dict, list, int]:
    if not element.lists:
        kind = np.dtype([(name, order + of) for name, of in element.scalars])
        if len(data) < start + element.count * kind.itemsize:
            raise _truncated(path, element, (len(data) - start) // max(kind.itemsize, 1))
        table = np.frombuffer(data, kind, element.count, start)
        columns = {name: table[name].astype(of) for name, of in element.scalars}
        return columns, [], start + element.count * kind.itemsize
    if len(element.lists) == 1 and not element.scalars:
        _, count_type, item_type = element.lists[0]
        kind = np.dtype([("n", order + count_type), ("i", order + item_type, (3,))])
        if len(data) >= start + element.count * kind.itemsize:
            table = np.frombuffer(data, kind, element.count, start)
            if (table["n"] == 3).all():  # the common case, at once
                return {}, [table["i"].astype(np.int64)], start + element.count * kind.itemsize
    return _read_binary_lists(path, element, data, start, order)


def _read_binary_lists(path: Path, element: _Element, data: bytes, start: int, order: str) -> tuple[dict, list, int]:
    lists = []
    skip = sum(np.dtype(kind).itemsize for _, kind in element.scalars)
    for found in range(element.count):
        start += skip
        for name, count_type, item_type in element.lists:
            kinds = np.dtype(order + count_type), np.dtype(order + item_type)
            if start + kinds[0].itemsize > len(data):
                raise _truncated(path, element, found)
            size = int(np.frombuffer(data, kinds[0], 1, start)[0])
            start += kinds[0].itemsize
            if start + size * kinds[1].itemsize > len(data):
                raise _truncated(path, element, found)
            if name in _POLYGON:
                lists.append(np.frombuffer(data, kinds[1], size, start).astype(np.int64))
            start += size * kinds[1].itemsize
    return {}, lists, start


def _fans(lists: list[np.ndarray]) -> np.ndarray:
    if len(lists) == 1 and lists[0].ndim == 2:
        return lists[0].astype(np.int32)
    fans = [np.stack([np.full(len(p) - 2, p[0]), p[1:-1], p[2:]], axis=1) for p in lists if len(p) >= 3]
    return np.concatenate(fans).astype(np.int32) if fans else np.zeros((0, 3), np.int32)
