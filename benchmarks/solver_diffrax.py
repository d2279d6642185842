"""The same film and tip equations by diffrax (vmapped Kvaerno5, float64), on the same draws, for the speed table.

    python -m pip install diffrax "jax[cpu]"        # not a dependency of eaclutch
    python benchmarks/solver_diffrax.py --record

Engagement to the crossing of 0.5 %; release as two solves, stuck and sliding back, to the tip's first x = 0 or
v = 0 (ours goes on to its final rest). CPU time of this process a simulation, compilation left out; draws that slip.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from measurement import record
from solver_draws import draws

from eaclutch.physics import tables as grid
from eaclutch.physics.kernels.ramp import driven_run
from eaclutch.physics.kernels.statics import driven_gap, rest_before
from eaclutch.physics.tables import tables

FIELDS = (
    "rise_time_constant", "fall_time_constant", "kappa_driven", "kappa_infinity", "relaxation_time", "exponent",
    "thickness", "cut", "inverse_sigma", "contact_scale", "film_mass", "damping", "substrate_weight", "film_static",
    "film_kinetic", "base_static", "base_kinetic", "stiffness", "mass", "load_cell_damping",
)  # fmt: skip


def prepare(number: int) -> dict[str, np.ndarray]:
    """Rows as arrays (draws,), with what the solves start from."""
    model, conditions, parameters = draws(number)
    status = model.predict(conditions, parameters, ["release_time_90_s"]).status["release"][0]
    rows = model.rows(conditions, parameters)[0][0][
        status == 0
    ]  # one that never slips would hold up the whole batch
    out = {name: np.array(rows[name]) for name in FIELDS}
    table, rest = tables(), []
    for row in rows:
        preload, before = rest_before(row, table)
        _, driven = driven_gap(row, preload, before, table)
        rest.append((preload + row["film_weight"], before, driven, driven_run(row, driven, before, table)[2]))
    out |= dict(zip(("load", "before", "driven", "start"), np.array(rest).T, strict=True))
    out["scale"] = rows["force_scale"] * rows["voltage"] ** 2
    return out


def build(rtol: float):
    """(engagement, release) as vmapped, compiled functions of ``prepare``'s arrays."""
    import diffrax
    import jax
    import jax.numpy as jnp
    import optimistix

    jax.config.update("jax_enable_x64", True)
    raw = tables()
    contact_cells = jnp.asarray(raw.contact.reshape(-1, 4))
    rough_cells = jnp.asarray(raw.roughness.reshape(grid.ROUGH_A_N - 1, grid.ROUGH_U_N - 1, 4, 4))
    relax_cells = jnp.asarray(raw.relaxation.reshape(grid.RELAX_ALPHA_N - 1, grid.RELAX_Y_N - 1, 4, 4))

    def cell(table, row, column):
        i = jnp.clip(row.astype(int), 0, table.shape[0] - 1)
        j = jnp.clip(column.astype(int), 0, table.shape[1] - 1)
        powers = jnp.arange(4)
        return (row - i) ** powers @ table[i, j] @ (column - j) ** powers

    def net(p, t, h, v, rising):
        position = (h * p["inverse_sigma"] - grid.CONTACT_X0) / grid.CONTACT_STEP
        i = jnp.clip(position.astype(int), 0, contact_cells.shape[0] - 1)
        lift = p["contact_scale"] * jnp.exp(contact_cells[i] @ (position - i) ** jnp.arange(4))
        decay = jnp.exp(-t / (p["rise_time_constant"] if rising else p["fall_time_constant"]))
        log_y = jnp.log(jnp.maximum(t, 1e-18) / p["relaxation_time"])
        left = cell(relax_cells, (p["exponent"] - grid.RELAX_ALPHA0) / grid.RELAX_ALPHA_STEP,
                    (log_y - grid.RELAX_Y0) / grid.RELAX_Y_STEP)  # fmt: skip
        left = 1.0 - left if rising else left
        kappa = p["kappa_infinity"] + (p["kappa_driven"] - p["kappa_infinity"]) * left
        film = p["thickness"] / kappa
        a, u = (1 - p["cut"]) * film * p["inverse_sigma"], (h + p["cut"] * film) * p["inverse_sigma"]
        average = jnp.exp(cell(rough_cells, (jnp.log(a) - grid.ROUGH_A0) / grid.ROUGH_A_STEP,
                               (u - grid.ROUGH_U0) / grid.ROUGH_U_STEP)) * p["inverse_sigma"] ** 2  # fmt: skip
        drive = (1.0 - decay) ** 2 if rising else decay**2
        return lift - p["scale"] * drive * average - p["load"] - p["damping"] / h**3 * v, lift

    def friction(p, t, y, which):
        force, lift = net(p, t, y[0], y[1], False)
        return p[f"base_{which}"] * (p["substrate_weight"] + p["load"] + force) + p[f"film_{which}"] * lift

    def film_rates(rising):
        return lambda t, y, p: jnp.array([y[1], net(p, t, y[0], y[1], rising)[0] / p["film_mass"]])

    def sliding(t, y, p):
        push = friction(p, t, y, "kinetic") - p["stiffness"] * y[2] - p["load_cell_damping"] * y[3]
        return jnp.array([y[1], net(p, t, y[0], y[1], False)[0] / p["film_mass"], y[3], push / p["mass"]])

    root = optimistix.Newton(1e-8, 1e-8)

    def solve(rates, t0, y0, p, event, atol):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(rates), diffrax.Kvaerno5(), t0, 0.11, 1e-9, y0, args=p, max_steps=4096, throw=False,
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=atol),
            event=diffrax.Event(event, root_finder=root),
        )  # fmt: skip

    def engagement(p):
        way = 0.005 * (p["before"] - p["driven"])
        crossed = lambda t, y, args, **_: y[0] - (args["before"] - way)  # noqa: E731
        atol = rtol * jnp.array([way, way / 1e-6])
        return solve(film_rates(True), 0.0, jnp.array([p["before"], 0.0]), p, crossed, atol).ts[-1]

    def release(p):
        way, x0 = p["before"] - p["driven"], p["start"] / p["stiffness"]
        atol = rtol * jnp.array([way, way / 1e-5, x0, x0 * 4000.0])
        lets_go = lambda t, y, args, **_: friction(args, t, y, "static") - args["start"]  # noqa: E731
        first = solve(film_rates(False), 0.0, jnp.array([p["driven"], 0.0]), p, lets_go, atol[:2])
        state = jnp.concatenate([first.ys[-1], jnp.array([x0, -1e-9 * x0])])
        ends = [lambda t, y, args, **_: y[2], lambda t, y, args, **_: y[3]]
        return solve(sliding, first.ts[-1], state, p, ends, atol).ts[-1]

    return jax.jit(jax.vmap(engagement)), jax.jit(jax.vmap(release))


def main() -> None:
    """Measure, print, record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=512)
    parser.add_argument("--rtol", type=float, default=1e-5)
    parser.add_argument("--record", action="store_true")
    options = parser.parse_args()
    values = prepare(options.draws)
    found: dict[str, float] = {}
    for name, function in zip(("engagement", "release"), build(options.rtol), strict=True):
        function(values).block_until_ready()
        start = time.process_time()
        result = np.asarray(function(values).block_until_ready())
        found[name] = (time.process_time() - start) / len(values["load"]) * 1e6
        print(f"diffrax {name:<10} {found[name]:10.1f} us, median {np.median(result) * 1e6:.2f} us")
    if options.record:
        record("solver_diffrax", "python benchmarks/solver_diffrax.py --record",
               {"draws": options.draws, "rtol": options.rtol, "us": found})  # fmt: skip


if __name__ == "__main__":
    main()
