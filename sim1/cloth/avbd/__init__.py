"""`SolverAVBD`: the deformation-stable cloth solver."""

from sim1.cloth.avbd.parameters import AVBDConfig, SelfContact
from sim1.cloth.avbd.solver import Broken, SolverAVBD

__all__ = ["AVBDConfig", "Broken", "SelfContact", "SolverAVBD"]
