"""A pull in MuJoCo: a flex with the same mesh, mass and (where it has a membrane) the same moduli.

Matched: mesh, mass per triangle's share of area as far as `flexcomp` spreads it (evenly over vertices), plane-stress modulus
and Poisson ratio of the membrane, bending rigidity (through modulus and thickness), step, gravity, no damping by choice.
Not matched: `edge equality` has no membrane, bending or limit of 5 %: it holds every edge at its length both ways; its softness is
MuJoCo's constraint law. The corner is held by the world and the pull is the frame's: gravity is tilted during the ramp, which is the
same motion seen from the corner.
"""

import time

import numpy as np

from benchmarks.solver.scenes import GRAVITY_M_S2, RIGIDITY_N_M, Cloth

# As stiff as MuJoCo lets a constraint be: a time constant of two steps. Which impedance stretches least depends on the mesh.
STIFF = '<edge equality="true" solref="{twice:.8f} 1" solimp="{low} {high} 0.001"/>'


class MujocoRun:
    """Two steps at a time, one thread."""

    def __init__(self, cloth: Cloth, dt_s: float, kind: str, modulus_n_m: float) -> None:
        import mujoco

        self._mujoco, self.dt_s = mujoco, dt_s
        self.model = mujoco.MjModel.from_xml_string(xml(cloth, dt_s, kind, modulus_n_m))
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        self.seconds, self.steps = 0.0, 0

    def advance(self) -> None:
        """Two steps."""
        from benchmarks.solver.contestants import RAMP_S, SPEED_M_S

        began = time.process_time()
        for _ in range(2):
            self.model.opt.gravity[0] = -SPEED_M_S / RAMP_S if self.steps * self.dt_s < RAMP_S else 0.0
            self._mujoco.mj_step(self.model, self.data)
            self.steps += 1
        self.seconds += time.process_time() - began

    def points(self) -> np.ndarray:
        """Positions (v, 3) [m], moved back into the frame of the world."""
        from benchmarks.solver.contestants import corner_way_m

        return self.data.flexvert_xpos + np.array([corner_way_m(self.steps * self.dt_s), 0.0, 0.0])


def xml(cloth: Cloth, dt_s: float, kind: str, modulus_n_m: float) -> str:
    """MJCF of the cloth.

    With both Lame moduli (of the plane) m: nu = 1/3, Young's modulus times thickness = 8/3 m; the thickness follows from the
    bending rigidity E h^3 / (12 (1 - nu^2)).
    """
    tension = 8.0 / 3.0 * modulus_n_m
    thickness = float(np.sqrt(12.0 * (1.0 - 1.0 / 9.0) * RIGIDITY_N_M / tension))
    elastic = (
        f'<edge equality="false"/><elasticity young="{tension / thickness:.8g}" poisson="{1 / 3:.8f}" '
        f'thickness="{thickness:.8g}" elastic2d="both"/>'
    )
    inside = {
        "MuJoCo elastic": ("discrete", elastic),
        "MuJoCo edges": ("implicitfast", '<edge equality="true"/>'),
        "MuJoCo edges 0.99": ("implicitfast", STIFF.format(twice=2.02 * dt_s, low=0.97, high=0.99)),
        "MuJoCo edges 0.9999": ("implicitfast", STIFF.format(twice=2.02 * dt_s, low=0.999, high=0.9999)),
    }
    integrator, law = inside[kind]
    points = " ".join(f"{value:.7g}" for value in cloth.start_m.reshape(-1))
    faces = " ".join(str(value) for value in cloth.faces.reshape(-1))
    held = " ".join(str(vertex) for vertex in cloth.held)
    return f"""<mujoco>
  <option timestep="{dt_s:.10g}" integrator="{integrator}" gravity="0 0 {-GRAVITY_M_S2}"/>
  <size memory="2G"/>
  <worldbody>
    <flexcomp name="cloth" type="direct" dim="2" point="{points}" element="{faces}" radius="0.002"
              mass="{cloth.density_kg_m2 * cloth.area_m2:.8g}">
      <contact selfcollide="none" contype="0" conaffinity="0"/>
      <pin id="{held}"/>
      {law}
    </flexcomp>
  </worldbody>
</mujoco>"""
