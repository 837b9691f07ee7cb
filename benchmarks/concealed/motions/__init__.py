"""What the grippers do: smooth commands of about four seconds, half a second of rest first."""

from benchmarks.concealed.motions import hanging, pulling, tabletop
from benchmarks.concealed.motions.motion import Motion

MOTIONS = {**hanging.MOTIONS, **pulling.MOTIONS, **tabletop.MOTIONS}
"""Name to the function (cloth, columns, rows, rng) that makes it."""

TABLE_MOTIONS = tuple(tabletop.MOTIONS)
FREE_MOTIONS = (*hanging.MOTIONS, *pulling.MOTIONS)
HANG = hanging.hang.__name__
"""Filmed beside others alone: it shows nothing best, and what hangs still leaves nothing to foretell."""

__all__ = ["FREE_MOTIONS", "HANG", "MOTIONS", "TABLE_MOTIONS", "Motion"]
