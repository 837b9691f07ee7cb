"""What keeps a bundle's recordings from being simulated, found before anything is simulated."""

from sim1.cloth.precise.held_places import held_places
from sim1.cloth.precise.material import marker_points, markers_on, sheet_of
from sim1.cloth.precise.mesh import refined
from sim1.cloth.precise.start import start_of
from sim1.recording.bundle import Bundle
from sim1.recording.problems import Problems


def require_simulable(bundle: Bundle) -> None:
    """Ask of what simulations are prepared from all that refuses a bundle: mesh, markers on it, starts, places in the grips.

    Raises:
        BadInput: a mesh that cannot be laid flat or is too small to bend, a marker off it, too few markers at the start of a recording,
            a grip in which nobody knows where the cloth sits.
    """
    sheet, points, problems = sheet_of(bundle), marker_points(bundle), Problems()
    for mesh in (sheet, refined(sheet)[0]):  # both are simulated: by one it is known what the other gets wrong
        _ = mesh.stencils
        markers_on(bundle, mesh, points)
    for recording in bundle.recordings:
        problems.attempt(start_of, bundle, recording, points, sheet)
    problems.stop()  # places are estimated from these starts
    held_places(bundle)
