"""`SolverAVBD`: the deformation-stable cloth solver."""

from sim1.cloth.avbd.parameters import PAPER_CLOTH, PAPER_ROBOT, PAPER_TABLE, AVBDConfig, SelfContact
from sim1.cloth.avbd.solver import Broken, SolverAVBD

__all__ = ["PAPER_CLOTH", "PAPER_ROBOT", "PAPER_TABLE", "AVBDConfig", "Broken", "SelfContact", "SolverAVBD"]
