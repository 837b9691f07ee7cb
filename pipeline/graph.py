"""The stage graph: `stages.yaml` read strictly, profiles and ablation variants applied.

A stage is one row of `stages.yaml`. A node is a stage in the base graph, or a stage as a variant changes it.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import pydantic
import yaml

from pipeline.home import Home


class GraphError(ValueError):
    """The graph's data are at fault; the message names the file, the stage and the key."""


class Stage(pydantic.BaseModel):
    """One row of `stages.yaml`."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True)

    name: str = pydantic.Field(pattern=r"^[a-z][a-z0-9_]*$")
    run: str = pydantic.Field(pattern=r"^[\w.]+:[a-z]\w*$")  # "module:function"; check_<name> stands beside it
    version: int = pydantic.Field(ge=1)  # raise it when the code's meaning changes
    group: str  # a heading in the UI
    per: Literal["garment"] | None = None  # None: the stage exists once
    needs: tuple[str, ...] = ()
    compares: tuple[str, ...] = ()  # stages needed from the base graph and from every variant
    sources: dict[str, str] = {}  # input name -> path below the home, {garment} allowed
    optional_sources: dict[str, str] = {}  # the same, may be absent
    resumes: bool = False  # goes on in what an interrupted run of the same recipe left
    updates: bool = (
        False  # starts from a copy of what the same version and function made last, even if that failed its checks
    )
    timings: bool = False  # also gets the seconds that every artifact took (not part of the recipe)
    config: dict[str, Any] = {}
    kinds: tuple[str, ...] = ()
    pool: str | None = None  # stages of one pool run one at a time
    summary: str = ""


@dataclass(frozen=True, kw_only=True)
class Node:
    """A stage in the base graph (`variant` None) or in a variant."""

    stage: Stage
    variant: str | None
    needs: Mapping[str, str] = field(default_factory=dict)  # input name -> node id
    config: Mapping[str, Any] = field(default_factory=dict)  # base, then profile, then variant

    @property
    def id(self) -> str:
        return node_id(self.stage.name, self.variant)

    @property
    def per(self) -> str | None:
        return self.stage.per


def node_id(stage: str, variant: str | None) -> str:
    return f"{variant}/{stage}" if variant else stage


@dataclass(frozen=True)
class Graph:
    """All nodes by id, parents before children."""

    nodes: Mapping[str, Node]
    profile: str
    variants: tuple[str, ...]

    def descendants(self, ids: set[str]) -> set[str]:
        """The nodes `ids` and everything downstream of them."""
        found = set(ids)
        for node in self.nodes.values():
            if found & set(node.needs.values()):
                found.add(node.id)
        return found

    def ancestors(self, ids: set[str]) -> set[str]:
        """The nodes `ids` and everything upstream of them."""
        found = set(ids)
        for node in reversed(self.nodes.values()):
            if node.id in found:
                found |= set(node.needs.values())
        return found


def load_graph(home: Home, profile: str | None = None) -> Graph:
    """Read `stages.yaml`, the profile and `ablations.yaml`.

    Raises:
        GraphError: an unknown key, a missing stage, a loop, an unknown profile: one line with file, stage and key.
    """
    folder = home.definitions
    profile = profile or home.profile()
    stages = _read_stages(folder / "stages.yaml")
    overrides = _read_profile(folder / "profiles" / f"{profile}.yaml", stages)
    variants = _read_variants(folder / "ablations.yaml", stages, profile)
    base = {
        stage.name: Node(
            stage=stage,
            variant=None,
            needs={name: name for name in (*stage.needs, *stage.compares)},
            config={**stage.config, **overrides.get(stage.name, {})},
        )
        for stage in stages.values()
    }
    nodes = {name: node for name, node in base.items() if not node.stage.compares}
    compared = {name for stage in stages.values() for name in stage.compares}
    needed = Graph(base, profile, ()).ancestors(compared)
    for variant, change in variants.items():
        wanted = Graph(base, profile, ()).ancestors({change.until}) if change.until else needed
        changed = Graph(base, profile, ()).descendants(set(change.settings)) & wanted
        for name in (name for name in base if name in changed):
            own = base[name]
            nodes[node_id(name, variant)] = Node(
                stage=own.stage,
                variant=variant,
                needs={need: node_id(need, variant) if need in changed else need for need in own.needs},
                config={**own.config, **change.settings.get(name, {})},
            )
    for node in (node for node in base.values() if node.stage.compares):
        needs = dict(node.needs)
        for variant in variants:
            ids = (node_id(name, variant) for name in node.stage.compares)
            needs |= {node: node for node in ids if node in nodes}
        nodes[node.id] = Node(stage=node.stage, variant=None, needs=needs, config=node.config)
    _forbid_below_comparison(base, folder / "stages.yaml")
    return Graph(nodes, profile, tuple(variants))


def _forbid_below_comparison(base: Mapping[str, Node], path: Path) -> None:
    comparing = {name for name, node in base.items() if node.stage.compares}
    for name, node in base.items():
        if under := comparing & set(node.needs):
            raise GraphError(f"{path}: stage {name!r} needs {sorted(under)}: nothing may stand below a comparison")


def _read_stages(path: Path) -> dict[str, Stage]:
    rows = _mapping(path).get("stages")
    if not isinstance(rows, list) or not rows:
        raise GraphError(f"{path}: expected a list under the key 'stages'")
    found: dict[str, Stage] = {}
    for position, row in enumerate(rows):
        name = row.get("name", f"#{position}") if isinstance(row, dict) else f"#{position}"
        try:
            stage = Stage.model_validate(row)
        except pydantic.ValidationError as error:
            raise GraphError(f"{path}: stage {name!r}: {_first(error)}") from None
        if stage.name in found:
            raise GraphError(f"{path}: stage {name!r} is declared twice")
        found[stage.name] = stage
    for stage in found.values():
        for need in (*stage.needs, *stage.compares):
            if need not in found:
                raise GraphError(f"{path}: stage {stage.name!r} needs {need!r}, which is not a stage")
        if clash := {*stage.sources, *stage.optional_sources} & {*stage.needs, *stage.compares, "timings"}:
            raise GraphError(f"{path}: stage {stage.name!r}: source and stage share the name {sorted(clash)}")
        for source in (*stage.sources.values(), *stage.optional_sources.values()):
            if re.findall(r"\{(.*?)\}", source) not in ([], [stage.per]):
                raise GraphError(f"{path}: stage {stage.name!r}: source {source!r} may only name {{{stage.per}}}")
        if stage.per is None:
            continue
        if joint := [need for need in stage.needs if found[need].per is None]:
            raise GraphError(
                f"{path}: stage {stage.name!r} is per garment and needs {joint}, which exist once: "
                "one garment's change would re-derive every garment"
            )
    return _sorted(found, path)


def _sorted(stages: dict[str, Stage], path: Path) -> dict[str, Stage]:
    done: dict[str, Stage] = {}
    while len(done) < len(stages):
        ready = [s for s in stages.values() if s.name not in done and {*s.needs, *s.compares} <= set(done)]
        if not ready:
            raise GraphError(f"{path}: stages {sorted(set(stages) - set(done))} need each other in a loop")
        done |= {stage.name: stage for stage in ready}
    return done


def _read_profile(path: Path, stages: Mapping[str, Stage]) -> dict[str, dict[str, Any]]:
    if not path.is_file():
        known = sorted(other.stem for other in path.parent.glob("*.yaml"))
        raise GraphError(f"profile {path.stem!r} does not exist; there are {known} in {path.parent}")
    return _overrides(_mapping(path), stages, str(path))


@dataclass(frozen=True, kw_only=True)
class _Variant:
    """What an ablation variant changes."""

    settings: Mapping[str, Mapping[str, Any]]  # stage -> settings
    until: str | None  # the last stage of which it has an artifact of its own


def _read_variants(path: Path, stages: Mapping[str, Stage], profile: str) -> dict[str, _Variant]:
    if not path.is_file():
        return {}
    rows = _mapping(path).get("variants") or {}
    found = {}
    for name, row in rows.items():
        where = f"{path}: variant {name!r}"
        if not re.fullmatch(r"[a-z][a-z0-9_]*", str(name)):
            raise GraphError(f"{where}: a name is made of a-z, 0-9 and _")
        if (
            not isinstance(row, dict)
            or set(row) - {"summary", "changes", "until", "profiles"}
            or not row.get("changes")
        ):
            raise GraphError(f"{where}: expected the keys 'summary', 'changes' (not empty), 'until', 'profiles'")
        until, profiles = row.get("until"), row.get("profiles", [profile])
        if until not in (None, *stages):
            raise GraphError(f"{where}: until {until!r} is not a stage; there are {sorted(stages)}")
        known = sorted(other.stem for other in (path.parent / "profiles").glob("*.yaml"))
        if not isinstance(profiles, list) or not set(profiles) <= set(known):
            raise GraphError(f"{where}: profiles {profiles!r}: expected a list of {known}")
        settings = _overrides(row["changes"], stages, where)
        if profile in profiles:
            found[name] = _Variant(settings=settings, until=until)
    return found


def _overrides(data: Mapping[str, Any], stages: Mapping[str, Stage], where: str) -> dict[str, dict[str, Any]]:
    for name, values in data.items():
        if name not in stages:
            raise GraphError(f"{where}: {name!r} is not a stage; there are {sorted(stages)}")
        if values is not None and not isinstance(values, dict):
            raise GraphError(f"{where}: stage {name!r}: expected settings as key: value, got {values!r}")
    return {name: dict(values or {}) for name, values in data.items()}


def _mapping(path: Path) -> dict[str, Any]:
    try:
        data = yaml.safe_load(path.read_text())
    except OSError as error:
        raise GraphError(f"{path}: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise GraphError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(data, dict):
        raise GraphError(f"{path}: expected a mapping at the top, got {type(data).__name__}")
    return data


def _first(error: pydantic.ValidationError) -> str:
    issue = error.errors()[0]
    place = ".".join(map(str, issue["loc"]))
    return f"key {place!r}: {issue['msg']}" + (f" (got {issue['input']!r})" if issue["type"] != "missing" else "")
