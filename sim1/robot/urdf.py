"""The part of URDF that the project's robots use: links of simple shapes, revolute, prismatic and fixed joints."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.stage import BadInput

JOINT_KINDS = ("revolute", "prismatic", "fixed")


@dataclass(frozen=True, kw_only=True)
class Shape:
    """One shape of a link, in the link's frame."""

    kind: str  # box, cylinder or sphere
    size_m: tuple[float, ...]  # box: edges x, y, z; cylinder: radius, length along z; sphere: radius
    origin: np.ndarray  # (4, 4) shape to link
    rgba: tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class Link:
    """A rigid body of the robot."""

    name: str
    mass_kg: float
    visuals: tuple[Shape, ...]
    collisions: tuple[Shape, ...]


@dataclass(frozen=True, kw_only=True)
class Joint:
    """How one link hangs on another. Limits in rad or m, rad/s or m/s."""

    name: str
    kind: str
    parent: str
    child: str
    origin: np.ndarray  # (4, 4) joint frame at zero to parent frame
    axis: np.ndarray  # (3,) unit, in the joint frame
    lower: float
    upper: float
    velocity: float


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A tree of links."""

    name: str
    links: dict[str, Link]
    joints: dict[str, Joint]

    def path(self, first: str, last: str) -> tuple[Joint, ...]:
        """Joints from link `first` down to link `last`.

        Raises:
            BadInput: `last` does not hang on `first`.
        """
        above = {joint.child: joint for joint in self.joints.values()}
        found: list[Joint] = []
        link = last
        while link != first:
            if link not in above:
                raise BadInput(f"robot {self.name!r}: link {last!r} does not hang on link {first!r}")
            found.append(above[link])
            link = above[link].parent
        return tuple(reversed(found))


def read_urdf(path: Path) -> Robot:
    """Read and check a URDF file.

    Raises:
        BadInput: not XML, an element is missing or unknown, a limit is absent or reversed, the links are no tree.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise BadInput(f"{path}: not a readable URDF ({error}); restore the file") from error
    try:
        colors = {m.get("name"): _numbers(m.find("color"), "rgba", 4) for m in root.findall("material")}
        links = {e.get("name"): _link(e, colors) for e in root.findall("link")}
        joints = {e.get("name"): _joint(e) for e in root.findall("joint")}
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error
    _check_tree(path, links, joints)
    return Robot(name=root.get("name", "robot"), links=links, joints=joints)


def rotation(axis: np.ndarray, angle: np.ndarray | float) -> np.ndarray:
    """Rotation matrices (..., 3, 3) about the unit `axis` (3,) by `angle` (...) in rad (Rodrigues)."""
    angle = np.asarray(angle, float)[..., None, None]
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)


def _numbers(element: ElementTree.Element | None, key: str, count: int) -> tuple[float, ...]:
    if element is None or element.get(key) is None:
        raise BadInput(f"attribute {key!r} is missing")
    try:
        values = tuple(float(word) for word in element.get(key, "").split())
    except ValueError as error:
        raise BadInput(f"{key}={element.get(key)!r} is not {count} numbers") from error
    if len(values) != count or not np.isfinite(values).all():
        raise BadInput(f"{key}={element.get(key)!r} is not {count} finite numbers")
    return values


def _origin(element: ElementTree.Element) -> np.ndarray:
    pose = np.eye(4)
    origin = element.find("origin")
    if origin is None:
        return pose
    if origin.get("rpy") is not None:
        roll, pitch, yaw = _numbers(origin, "rpy", 3)
        x, y, z = np.eye(3)
        pose[:3, :3] = rotation(z, yaw) @ rotation(y, pitch) @ rotation(x, roll)
    if origin.get("xyz") is not None:
        pose[:3, 3] = _numbers(origin, "xyz", 3)
    return pose


def _link(element: ElementTree.Element, colors: dict) -> Link:
    mass = element.find("inertial/mass")
    return Link(
        name=element.get("name", ""),
        mass_kg=_numbers(mass, "value", 1)[0] if mass is not None else 0.0,
        visuals=tuple(_shape(e, colors) for e in element.findall("visual")),
        collisions=tuple(_shape(e, colors) for e in element.findall("collision")),
    )


def _shape(element: ElementTree.Element, colors: dict) -> Shape:
    material = element.find("material")
    rgba = colors.get(material.get("name"), (0.7,) * 3 + (1.0,)) if material is not None else (0.7, 0.7, 0.7, 1.0)
    geometry = element.find("geometry")
    solid = geometry[0] if geometry is not None and len(geometry) else None
    if solid is None or solid.tag not in ("box", "cylinder", "sphere"):
        raise BadInput(f"geometry {solid.tag if solid is not None else None!r}: expected box, cylinder or sphere")
    if solid.tag == "box":
        size = _numbers(solid, "size", 3)
    elif solid.tag == "cylinder":
        size = _numbers(solid, "radius", 1) + _numbers(solid, "length", 1)
    else:
        size = _numbers(solid, "radius", 1)
    if min(size) <= 0:
        raise BadInput(f"{solid.tag} of size {size} m: sizes must be greater than 0")
    return Shape(kind=solid.tag, size_m=size, origin=_origin(element), rgba=rgba)


def _joint(element: ElementTree.Element) -> Joint:
    name, kind = element.get("name", ""), element.get("type", "")
    ends = [element.find("parent"), element.find("child")]
    if kind not in JOINT_KINDS or None in ends:
        raise BadInput(f"joint {name!r} of type {kind!r}: expected a parent, a child and one of {JOINT_KINDS}")
    parent, child = (end.get("link", "") for end in ends)
    lower = upper = velocity = 0.0
    axis = np.array([1.0, 0.0, 0.0])
    if kind != "fixed":
        limit = element.find("limit")
        lower, upper, velocity = (_numbers(limit, key, 1)[0] for key in ("lower", "upper", "velocity"))
        axis = np.array(_numbers(element.find("axis"), "xyz", 3))
        if not lower < upper or velocity <= 0 or not np.isclose(np.linalg.norm(axis), 1, atol=1e-6):
            raise BadInput(
                f"joint {name!r}: lower {lower}, upper {upper}, velocity {velocity}, axis {axis} do not make sense"
            )
    return Joint(
        name=name, kind=kind, parent=parent, child=child, origin=_origin(element), axis=axis,
        lower=lower, upper=upper, velocity=velocity,
    )  # fmt: skip


def _check_tree(path: Path, links: dict[str, Link], joints: dict[str, Joint]) -> None:
    children = [joint.child for joint in joints.values()]
    named = {*children, *(joint.parent for joint in joints.values())}
    if unknown := sorted(named - set(links)):
        raise BadInput(f"{path}: joints name links that do not exist: {unknown}")
    if len(set(children)) != len(children) or len(children) != len(links) - 1:
        raise BadInput(f"{path}: {len(links)} links and {len(joints)} joints do not form one tree")
    above = {joint.child: joint.parent for joint in joints.values()}
    for link in links:
        way = [link]
        while (parent := above.get(way[-1])) is not None:  # up to the one link that hangs on nothing
            if parent in way:
                raise BadInput(
                    f"{path}: link {parent!r} hangs on itself by way of {way}; correct the parent of a joint"
                )
            way.append(parent)
