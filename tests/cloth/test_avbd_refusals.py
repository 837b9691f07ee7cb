import dataclasses

import newton
import numpy as np
import pytest
import warp as wp
from avbd_sheets import DEVICE, add_cloth, square_grid

from sim1.cloth.avbd import AVBDConfig, SelfContact, SolverAVBD

NUMBERS = [f.name for f in dataclasses.fields(AVBDConfig) if type(f.default) in (int, float)]
LAYER_NUMBERS = [f.name for f in dataclasses.fields(SelfContact)]


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_of_the_solver_that_is_nan_or_negative_is_refused_by_name(name):
    for bad in (float("nan"), -1.0):
        with pytest.raises(ValueError, match=name):
            AVBDConfig(**{name: bad})


@pytest.mark.parametrize("name", LAYER_NUMBERS)
def test_a_number_of_the_self_contact_that_is_nan_or_negative_is_refused_by_name(name):
    for bad in (float("nan"), -1.0):
        with pytest.raises(ValueError, match=name):
            SelfContact(**{name: bad})


def test_an_unknown_integrator_is_refused_by_name():
    with pytest.raises(ValueError, match="leapfrog"):
        AVBDConfig(integrator="leapfrog")


@pytest.mark.parametrize("name", ["strain_stiffness_n_m", "friction_speed_m_s", "iterations"])
def test_zero_is_refused_where_it_would_divide_or_do_nothing(name):
    with pytest.raises(ValueError, match=name):
        AVBDConfig(**{name: 0})


def test_no_limit_of_strain_is_a_limit_of_infinity():
    assert AVBDConfig(max_strain=float("inf")).max_strain == float("inf")


def test_the_defaults_are_accepted():
    AVBDConfig()
    AVBDConfig(self_contact=SelfContact())


def builder_of_a_cloth() -> newton.ModelBuilder:
    builder = newton.ModelBuilder()
    add_cloth(builder, *square_grid(3, 3, 0.1))
    return builder


def test_a_model_with_springs_is_refused_with_their_number():
    builder = builder_of_a_cloth()
    for end in (1, 2, 3):
        builder.add_spring(0, end, 1.0, 0.0, 0.0)
    builder.color()
    with pytest.raises(ValueError, match="3 springs"):
        SolverAVBD(builder.finalize(device=DEVICE))


def test_a_model_with_tetrahedra_is_refused_with_their_number():
    builder = builder_of_a_cloth()
    for corner in np.eye(4, 3, k=-1):
        builder.add_particle(wp.vec3(*map(float, corner)), wp.vec3(0.0), 0.1)
    builder.add_tetrahedron(9, 10, 11, 12)
    builder.color()
    with pytest.raises(ValueError, match="1 tet"):
        SolverAVBD(builder.finalize(device=DEVICE))


@pytest.mark.parametrize("fused", [True, False])
def test_a_model_without_cloth_is_refused_for_that_whatever_sweeps_it(fused):
    builder = newton.ModelBuilder()
    builder.add_particle(wp.vec3(0.0), wp.vec3(0.0), 0.1)
    with pytest.raises(ValueError, match="no triangles"):
        SolverAVBD(builder.finalize(device=DEVICE), AVBDConfig(fused=fused))
