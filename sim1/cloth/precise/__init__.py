"""The accurate simulator of a recorded sheet, for identification: implicit, second order, converged in every step.

`SolverAVBD` trades accuracy for speed and contact; its damping by few sweeps would be read as a material. Here a sheet without
self-contact is solved to a micrometre, and the derivative of every marker with respect to any parameter comes with it.
"""

from pathlib import Path

from sim1.cloth.precise.compiled_code import forget_stale

forget_stale(Path(__file__).parent)
