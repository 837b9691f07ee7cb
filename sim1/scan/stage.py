"""Stages `scan` (strict ingest of a garment's scan) and `garment_mesh` (scan to simulation mesh). Paper: geometric alignment."""

from pathlib import Path

from sim1.stage import BadInput, Facts, Finding, Inputs, garment_of, only, stage_config


@stage_config
class ScanConfig:
    """What counts as a scan of a garment."""

    smallest_m: float = 0.08  # longest side of a bounding box; a sock is 0.1 m long
    largest_m: float = 4.0  # a bed sheet is 3 m long
    point_count: int = 1000  # fewer do not show the shape of a garment
    spacing_m: float = 0.003  # a user's mesh is sampled this densely
    seed: int = 1  # of that sampling


def scan(inputs: Inputs, out: Path, config: ScanConfig) -> Facts:
    """Check a garment's scan files and write them as canonical arrays in metres.

    Raises:
        BadInput: see `sim1.scan.ingest.ingest` and `sim1.scan.garment_file.read_garment_file`.
    """
    from sim1.scan.cloud import write_scan
    from sim1.scan.garment_file import canonical_json, read_garment_file
    from sim1.scan.ingest import ingest
    from sim1.scan.scan_picture import draw_scan

    garment = read_garment_file(only(inputs, "garment"))
    found = ingest(
        only(inputs, "scans"),
        garment,
        size_m=(config.smallest_m, config.largest_m),
        point_count=config.point_count,
        spacing_m=config.spacing_m,
        seed=config.seed,
    )
    if garment.virtual != (found.truth is not None):
        raise BadInput(
            f"{only(inputs, 'garment')}: virtual is {garment.virtual}, but truth.npz is"
            f" {'present' if found.truth is not None else 'missing'} in {only(inputs, 'scans')};"
            " only a virtual scan has a truth: for a scan of your own leave the key `virtual` out of the garment file"
        )
    write_scan(out, found)
    (out / "garment.json").write_text(canonical_json(garment), encoding="utf-8")
    draw_scan(found, f"{garment.title}: {'virtual scan' if garment.virtual else 'scan'}", out / "scan.png")
    size = found.cloud.points_m.max(axis=0) - found.cloud.points_m.min(axis=0)
    return {
        "origin": "virtual scan (depth-camera model)" if garment.virtual else "scan files of the user",
        "points": len(found.cloud),
        "views": len(found.scanner_to_world),
        "size_m": [round(float(value), 4) for value in size],
        "support": found.support is not None,
        "manual_mask": found.mask is not None,
    }


def check_source_garment(path: Path) -> None:
    """Raises BadInput where the garment file is at fault: before any work, rather than in the middle of it."""
    from sim1.scan.garment_file import read_garment_file

    read_garment_file(path)


def check_scan(artifact: Path) -> list[Finding]:
    """Is the scan complete enough to make a mesh of?"""
    from sim1.scan.cloud import read_scan
    from sim1.scan.scan_check import scan_findings

    return scan_findings(read_scan(artifact))


@stage_config
class GarmentMeshConfig:
    """Sizes of the simulation mesh, and of the surface that it is taken from."""

    edge_m: float = 0.0215  # edge length of the simulation mesh: the towel gets 330 vertices, a fold still 20 edges
    vertex_count: int = 900  # most vertices, about; a shirt's edges become longer for it (30 mm)
    cell_m: float = 0.0025  # Poisson cells; about the spacing of the points
    gap_spacings: float = 4.0  # a gap wider than twice this many point spacings is a hole or an opening
    taubin_steps: int = 5  # more of them iron out wrinkles too
    angle_deg: float = 18.0  # smallest angle aimed at; the check asks for 15
    texture_pixels: int = 512  # side of the texture; 2 mm a texel on a shirt
    seed: int = 1  # of the samples that the accuracy is measured with


def garment_mesh(inputs: Inputs, out: Path, config: GarmentMeshConfig) -> Facts:
    """Turn a scan into a textured simulation mesh in metres, and measure how accurate it is.

    Raises:
        BadInput: see `sim1.scan.build.build`.
    """
    from sim1.scan.write_mesh import make_garment_mesh

    return make_garment_mesh(only(inputs, "scan"), out, config, garment_of(inputs))


def check_garment_mesh(artifact: Path) -> list[Finding]:
    """Is the mesh fit for simulation, open where the garment is, and as accurate as promised?"""
    from sim1.scan.mesh_check import mesh_findings

    return mesh_findings(artifact)
