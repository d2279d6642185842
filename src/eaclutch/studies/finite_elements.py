"""Finite-element check of the analytic pressure: two comb electrodes under a film, a gap, and a substrate.

The cross-section spans the comb from one electrode's centre to the next one's, with mirror symmetry at both
ends. From below: air, electrodes on the film's lower face, the film,
the air gap, and the substrate, which is a conductor at floating potential or an insulator of a given
permittivity with air above. Laplace's equation div(kappa grad phi) = 0 with biquadratic elements on a graded
tensor grid; the floating potential follows from zero net charge on the conductor; the pressure is Maxwell's
stress on the substrate's lower face.

Source: Rauf & Follmer (2025), Sec. 2.1 (Fig. 2) and Supplement S3.2, doi:10.1016/j.eml.2025.102382.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.constants import epsilon_0
from skfem import Basis, BilinearForm, ElementQuad2, FacetBasis, Functional, MeshQuad, condense, solve
from skfem.helpers import dot, grad

from eaclutch.records import FieldSolution, FloatArray, Pad

AIR_BELOW = 1e-3  # m; the field under the electrodes has died out by then
AIR_ABOVE = 1e-3  # m


@dataclass(frozen=True)
class CrossSection:
    """Geometry and materials of one comb period. ``substrate_permittivity`` None: a floating conductor."""

    film_permittivity: float
    gap: float
    film_thickness: float = 24e-6
    electrode_length: float = 1.5e-3
    electrode_gap: float = 0.5e-3
    substrate_permittivity: float | None = None
    substrate_thickness: float = 2e-3

    @classmethod
    def of_pad(
        cls, pad: Pad, film_permittivity: float, gap: float, substrate_permittivity: float | None = None
    ) -> CrossSection:
        """The cross-section of a pad at one gap [m]."""
        lengths = (pad.film_thickness, pad.electrode_length, pad.electrode_gap)
        return cls(film_permittivity, gap, *lengths, substrate_permittivity)


def _graded(length: float, first: float, growth: float = 1.35) -> FloatArray:
    """Offsets from 0 to ``length`` in steps that start at ``first`` and grow. Returns (points,)."""
    steps = [first]
    while sum(steps) < length:
        steps.append(steps[-1] * growth)
    offsets = np.concatenate([[0.0], np.cumsum(steps)])
    return offsets * (length / offsets[-1])


def _grid_x(section: CrossSection, refinement: int) -> FloatArray:
    """x from one electrode's centre to the next one's, fine at the edges. Returns (points,) [m].

    The alternating comb is mirror symmetric about both centres, so this half period is the whole problem.
    """
    half_gap, half_electrode = section.electrode_gap / 2, section.electrode_length / 2
    first = min(section.film_thickness, section.gap) / (2 * refinement)
    growth = 1 + 0.35 / refinement
    inner = half_gap - _graded(half_gap, first, growth)[::-1]
    outer = half_gap + _graded(half_electrode, first, growth)
    right = np.unique(np.concatenate([inner, outer]))
    return np.unique(np.round(np.concatenate([-right[::-1], right]), 15))


def _grid_y(section: CrossSection, refinement: int) -> tuple[FloatArray, dict[str, float]]:
    """y levels, zero at the electrodes, and the heights of the interfaces."""
    film, gap = section.film_thickness, section.gap
    tops = {"film": film, "gap": film + gap}
    growth = 1 + 0.35 / refinement
    first = min(film, gap) / (3 * refinement)
    parts = [-_graded(AIR_BELOW, first, growth), np.linspace(0, film, 8 * refinement + 1)]
    parts.append(np.linspace(film, film + gap, 4 * refinement + 1))
    if section.substrate_permittivity is not None:
        tops["substrate"] = tops["gap"] + section.substrate_thickness
        parts.append(tops["gap"] + _graded(section.substrate_thickness, first, growth))
        parts.append(tops["substrate"] + _graded(AIR_ABOVE, section.substrate_thickness / 20, growth))
    return np.unique(np.round(np.concatenate(parts), 15)), tops


def _permittivity(section: CrossSection, y: FloatArray, tops: dict[str, float]) -> FloatArray:
    kappa = np.where((y > 0) & (y < tops["film"]), section.film_permittivity, 1.0)
    if section.substrate_permittivity is not None:
        inside = (y > tops["gap"]) & (y < tops["substrate"])
        kappa = np.where(inside, section.substrate_permittivity, kappa)
    return kappa


@BilinearForm
def _stiffness(u, v, w):  # type: ignore[no-untyped-def]
    return w["kappa"] * dot(grad(u), grad(v))


@Functional
def _stress(w):  # type: ignore[no-untyped-def]
    gradient = grad(w["potential"])
    return epsilon_0 / 2 * (gradient[1] ** 2 - gradient[0] ** 2)


def solve_field(section: CrossSection, voltage: float, refinement: int = 2) -> FieldSolution:
    """Solve one cross-section with one electrode at ``voltage`` and its neighbour at 0.

    ``refinement`` scales the number of cells per layer; the mesh-convergence test doubles it.
    """
    y, tops = _grid_y(section, refinement)
    mesh = MeshQuad.init_tensor(_grid_x(section, refinement), y)
    basis = Basis(mesh, ElementQuad2())
    kappa = _permittivity(section, mesh.p[1, mesh.t].mean(axis=0), tops)
    matrix = _stiffness.assemble(basis, kappa=np.repeat(kappa[:, None], basis.X.shape[1], axis=1))
    x_node, y_node = basis.doflocs
    tolerance = 1e-12
    electrodes = np.abs(y_node) < tolerance
    live = np.flatnonzero(electrodes & (x_node <= -section.electrode_gap / 2 + tolerance))
    ground = np.flatnonzero(electrodes & (x_node >= section.electrode_gap / 2 - tolerance))
    fixed = np.concatenate([live, ground])
    driven = np.zeros(basis.N)
    driven[live] = voltage
    if section.substrate_permittivity is not None:
        potential, floating = solve(*condense(matrix, x=driven, D=fixed)), np.nan
    else:
        metal = np.flatnonzero(np.abs(y_node - tops["gap"]) < tolerance)
        fixed = np.concatenate([fixed, metal])
        raised = np.zeros(basis.N)
        raised[metal] = 1.0
        by_electrodes = solve(*condense(matrix, x=driven, D=fixed))
        by_metal = solve(*condense(matrix, x=raised, D=fixed))
        # The reaction summed over the metal is its charge: zero for a floating conductor.
        floating = -float((matrix @ by_electrodes)[metal].sum() / (matrix @ by_metal)[metal].sum())
        potential = by_electrodes + floating * by_metal
    nodes = basis.nodal_dofs[0]
    return FieldSolution(
        _pressure(section, mesh, potential, tops),
        _gap_voltage(section, mesh, potential[nodes], tops),
        floating, mesh.p[0], mesh.p[1], potential[nodes],
    )  # fmt: skip


def _pressure(section: CrossSection, mesh: MeshQuad, potential: FloatArray, tops: dict[str, float]) -> float:
    """Maxwell's stress at mid-gap, averaged over the electrodes' length [Pa].

    Any horizontal cut through the air gap carries the same force; mid-gap is clear of the singular corners.
    """
    middle = (tops["film"] + tops["gap"]) / 2
    level = mesh.p[1][np.argmin(np.abs(mesh.p[1] - middle))]
    facets = mesh.facets_satisfying(lambda p: np.abs(p[1] - level) < 1e-12)
    cut = FacetBasis(mesh, ElementQuad2(), facets=facets)
    return float(_stress.assemble(cut, potential=potential) / section.electrode_length)


def _gap_voltage(
    section: CrossSection, mesh: MeshQuad, potential: FloatArray, tops: dict[str, float]
) -> float:
    """Mean |potential difference| across the air gap above the electrodes [V]."""
    x = np.unique(mesh.p[0])
    faces = []
    for level in (tops["film"], tops["gap"]):
        row = np.flatnonzero(np.abs(mesh.p[1] - level) < 1e-12)
        row = row[np.argsort(mesh.p[0, row])]
        faces.append(potential[row])
    difference = np.abs(faces[1] - faces[0])
    over = np.abs(x) >= section.electrode_gap / 2 - 1e-12
    left, right = over & (x < 0), over & (x > 0)
    integral = np.trapezoid(difference[left], x[left]) + np.trapezoid(difference[right], x[right])
    return float(integral / section.electrode_length)
