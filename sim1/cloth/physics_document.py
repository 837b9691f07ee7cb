"""The contents of a model file (`sim1.model/1`) as strict models: no key unknown or missing, no text where a number belongs."""

from typing import Annotated, Self

import pydantic
from pydantic import Discriminator, Field, Tag

from sim1.data_file import Strict

SCHEMA = "sim1.model/1"
MOST_REFINED = 3  # 64 faces for one: more is a slip

type Number = Annotated[float, Field(strict=True)]  # a whole one too; neither "400" nor yes
type Positive = Annotated[float, Field(strict=True, gt=0)]
type Place = Annotated[list[Number], Field(min_length=3, max_length=3)]
type NumberOrDirection = Annotated[
    Annotated[Number, Tag("number")] | Annotated[Place, Tag("direction")],
    Discriminator(lambda value: "direction" if isinstance(value, list) else "number"),
]


def _rising(edges: list[float]) -> list[float]:
    if edges[0] > edges[1]:
        raise ValueError("an interval is [low, high]")
    return edges


type Interval = Annotated[list[Number], Field(min_length=2, max_length=2), pydantic.AfterValidator(_rising)]


class AnyPart(Strict):
    """A value and its 95 % interval, null where nothing was measured."""

    value: Number
    ci95: Interval | None


class PositivePart(AnyPart):
    """Of what is more than nothing."""

    value: Positive


class LeastPart(AnyPart):
    """Of what may be nothing."""

    value: Annotated[float, Field(strict=True, ge=0)]


class PoissonPart(AnyPart):
    """Of what a stable sheet has."""

    value: Annotated[float, Field(strict=True, ge=-0.99, lt=0.99)]


class FrictionPart(Strict):
    """What the garment touches."""

    table: LeastPart
    robot: LeastPart
    self: LeastPart


class ParameterPart(Strict):
    """A parameter of an effect; which effect has which, in which unit, is not asked here."""

    value: NumberOrDirection
    ci95: Interval | None
    unit: str


class EffectPart(Strict):
    """A named addition to the baseline."""

    name: str
    parameters: dict[str, ParameterPart]


class GripPart(Strict):
    """A lab's grip that calibration found: where its vertices sit in the drive's frame, in one recording or in all."""

    drive: str
    vertices: Annotated[list[Annotated[int, Field(strict=True, ge=0)]], Field(min_length=1)]
    places_m: list[Place]
    recording: str | None = None

    @pydantic.model_validator(mode="after")
    def _one_place_each(self) -> Self:
        if len(self.places_m) != len(self.vertices):
            raise ValueError(
                f"{len(self.places_m)} places_m for {len(self.vertices)} vertices, expected one (x, y, z) each"
            )
        if len(set(self.vertices)) != len(self.vertices):
            raise ValueError("vertices holds one twice")
        return self


class MeshPart(Strict):
    """What the identification simulator's own mesh was found to get wrong."""

    length_u: Positive | None = None
    length_v: Positive | None = None
    clamp: Positive | None = None
    rim: Positive | None = None


class PhysicsDocument(Strict):
    """All of a model file but its schema."""

    area_density_kg_m2: PositivePart
    thickness_m: PositivePart
    stretch_n_m: PositivePart
    poisson: PoissonPart
    bending_n_m: LeastPart
    damping_s: LeastPart
    friction: FrictionPart
    effects: list[EffectPart] = Field(default_factory=list)
    grips: list[GripPart] = Field(default_factory=list)
    mesh: MeshPart = MeshPart()
    mesh_refined: Annotated[int, Field(strict=True, ge=0, le=MOST_REFINED)] | None = None

    @pydantic.model_validator(mode="after")
    def _each_grip_once(self) -> Self:
        keys = [(grip.drive, tuple(grip.vertices), grip.recording) for grip in self.grips]
        if twice := [key for key in keys if keys.count(key) > 1]:
            drive, vertices, recording = twice[0]
            raise ValueError(
                f"grips holds drive {drive!r} with vertices {list(vertices)}{f' in {recording}' if recording else ''} twice"
            )
        return self
