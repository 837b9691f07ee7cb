"""Recordings of a garment's fabric: a lab's bundle where the user has one, else a stand-in lab that says that it is one."""

import json
from math import isfinite
from pathlib import Path

from pydantic import Field

from sim1.stage import BadInput, Facts, Finding, Inputs, garment_of, only, random_stream, stage_config


@stage_config
class RealityConfig:
    """What plays reality; where there are recordings of real cloth, nothing is drawn."""

    seed: int = 1  # of the concealed fabric
    # Probability of effects that the baseline lacks, by name (`sim1.recording.concealed`); those of the table show in no recording.
    effects: dict[str, float] = Field(
        default_factory=lambda: {
            "air_drag": 1.0,  # there is air in every room; without it, a scripted fold throws the T-shirt about
            "anisotropic_bending": 0.3,
            "anisotropic_stretch": 0.2,
            "bending_hysteresis": 0.2,
            "anisotropic_friction": 0.3,
            "static_friction": 0.3,
        }
    )
    friction_log_off: tuple[float, float] = (0.15, 0.4)  # off what simulations assume, either way; they never learn it


def reality(inputs: Inputs, out: Path, config: RealityConfig) -> Facts:
    """Conceal a fabric: the stand-in lab films it, policies are tried with it, no stage between them sees it.

    Raises:
        BadInput: the garment file is at fault, or the settings.
    """
    from sim1.recording.reality import write_real, write_stand_in
    from sim1.scan.garment_file import read_garment_file

    if inputs.get("recordings"):
        write_real(out)
        return {"what": "there are recordings of real cloth", "virtual": False}
    file = read_garment_file(only(inputs, "garment"))
    settings = (config.seed, config.effects, config.friction_log_off)
    write_stand_in(out, file, garment_of(inputs), *settings)
    return {"what": "stand-in for reality: a simulated fabric, concealed", "virtual": True}


def check_reality(artifact: Path) -> list[Finding]:
    """The concealed world reads."""
    from sim1.recording.reality import read_world

    try:
        world = read_world(artifact)
    except BadInput as error:
        return [Finding(name="world_reads", passed=False, detail=str(error))]
    return [Finding(name="world_reads", passed=True, detail="real cloth" if world is None else "a stand-in")]


@stage_config
class RecordingsConfig:
    """Sizes of the stand-in lab; a bundle in `data/recordings/` uses none of them."""

    seed: int = 1  # of the cameras' noise
    side_m: float = 0.3  # square swatch, a usual size of fabric samples
    vertices_per_side: int = 8  # of the bundle's mesh, which the diagnosis refines once; even: the jaws are alike
    lab_vertices_per_side: int = 29  # four lab cells a bundle cell; the diagnosis has two
    lab_step_s: float = 1 / 240  # a quarter of the step that the diagnosis searches with
    duration_s: float = 1.7  # of a recording; 0.5 s at rest come first
    markers_per_side: int = 5  # 25 markers
    marker_rate_hz: float = 60.0  # slow motion-capture rate
    noise_std_m: float = 7e-4  # per coordinate; cameras at 2 m resolve 0.3 to 1 mm
    outlier_share: float = 0.005  # of samples with six times the noise
    dropout_share: float = 0.03  # of samples that are occluded, six frames at a time
    swings: tuple[str, ...] = ("slow", "fast", "mixed")  # motions; the diagnosis holds one of them out


def recordings(inputs: Inputs, out: Path, config: RecordingsConfig) -> Facts:
    """Check and copy the lab's bundle, or film a virtual swatch; writes `bundle/`, `origin.json` and a picture.

    Raises:
        BadInput: the given bundle is damaged or inconsistent, or the garment file is.
    """
    from sim1.recording.bundle import read_bundle, write_bundle
    from sim1.recording.pictures import draw_paths

    given = inputs.get("recordings", {})
    if given:
        bundle = read_bundle(only(inputs, "recordings"))
        origin = {"virtual": False, "what": "recordings of real cloth, as given"}
        title = "as recorded"
    else:
        bundle, origin = _stand_in(inputs, config)
        title = "STAND-IN LAB, simulated"
    write_bundle(out / "bundle", bundle)
    (out / "origin.json").write_text(json.dumps(origin, indent=1, sort_keys=True) + "\n")
    draw_paths(out / "paths.png", bundle, title)
    rows = [
        {
            "recording": recording.name,
            "duration_s": round(float(recording.time_s[-1] - recording.time_s[0]), 3),
            "frames": len(recording.time_s),
            "seen_percent": round(100 * float(recording.seen.mean()), 1),
        }
        for recording in bundle.recordings
    ]
    return {
        "origin": origin["what"],
        "virtual": origin["virtual"],
        "markers": len(bundle.anchors.marker),
        "recordings": rows,
    }


def _stand_in(inputs: Inputs, config: RecordingsConfig):
    import hashlib

    from sim1.progress import track
    from sim1.recording.lab import SWINGS, Setup, record, truth
    from sim1.recording.reality import priors_of, read_world
    from sim1.scan.garment_file import read_garment_file

    if config.vertices_per_side % 2 or (config.lab_vertices_per_side - 1) % (config.vertices_per_side - 1):
        raise BadInput(
            f"recordings config: vertices_per_side is {config.vertices_per_side} and lab_vertices_per_side {config.lab_vertices_per_side}; "
            "the first is even, and the lab's cells divide the bundle's"
        )
    if unknown := sorted(set(config.swings) - set(SWINGS)):
        raise BadInput(f"recordings config: swings {unknown} are unknown; choose from {sorted(SWINGS)}")
    priors = priors_of(read_garment_file(only(inputs, "garment")))
    garment, world = garment_of(inputs), read_world(only(inputs, "reality"))
    if world is None:
        raise BadInput("recordings: reality is real and there is no bundle to copy; make reality again")
    sizes = {name: getattr(config, name) for name in Setup.__dataclass_fields__}
    bundle = record(
        priors,
        world,
        Setup(**sizes),
        random_stream(config.seed, garment, "cameras"),
        lambda names: track(names, "filming the swatch"),
    )
    seal = hashlib.sha256(json.dumps(truth(world), sort_keys=True).encode()).hexdigest()
    origin = {
        "virtual": True,
        "what": "stand-in for a lab: a simulated swatch, not measured",
        "concealed": {"sha256": seal},
        "shares_with_estimator": "the simulator with all its formulas; not its mesh, its time step or its parameters",
    }
    return bundle, origin


def check_recordings(artifact: Path) -> list[Finding]:
    """The bundle reads strictly, has motion to fit and motion to hold out, and enough of it was seen."""
    from sim1.recording.bundle import read_bundle
    from sim1.recording.motion import COARSE, rest_until_s

    try:
        bundle = read_bundle(artifact / "bundle")
    except BadInput as error:
        return [Finding(name="bundle_reads", passed=False, detail=str(error))]
    names = [recording.name for recording in bundle.recordings]
    seen = min(float(recording.seen.mean()) for recording in bundle.recordings)
    still = [r.name for r in bundle.recordings if r.starts == "rest" and not isfinite(rest_until_s(r, COARSE))]
    return [
        Finding(
            name="bundle_reads", passed=True, detail=f"{len(names)} recordings of {len(bundle.anchors.marker)} markers"
        ),
        Finding(
            name="held_out_motion",
            passed=len(names) >= 2,
            detail=f"{len(names)} recordings; a fit and a test need 2 or more",
        ),
        Finding(
            name="markers_seen",
            passed=seen >= 0.3,
            detail=f"at least {100 * seen:.0f} % of samples seen (limit 30 %)",
            blocking=False,
        ),
        Finding(
            name="drives_move",
            passed=not still,
            detail=f"in {still} no drive moves by 1 mm or turns by 0.01 rad, and no hold changes: drop them"
            if still
            else "in every recording a drive moves, or the cloth does from its start",
        ),
    ]
