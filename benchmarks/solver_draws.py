"""Random simulations over the clutch's whole range, for the solver's benchmarks."""

from __future__ import annotations

import numpy as np

from eaclutch.physics.effects import BASE
from eaclutch.physics.model import ClutchModel
from eaclutch.records import Bench, FloatArray, RunConditions, Substrate

BENCH = Bench(name="benchmark", substrates={"brass": Substrate(density=8049.0)})
WIDTHS = {2.0: 2.0, 2.5: 2.5, 3.0: 3.0, 4.0: 2.0, 5.0: 2.5, 6.0: 3.0}  # mm: thickness in mm


def conditions(
    voltage: FloatArray, frequency: FloatArray, width: FloatArray, thickness: FloatArray, friction: FloatArray
) -> RunConditions:
    """Runs [V, Hz, m, m, N] of 3 s, each (runs,); the force at switch-off is the model's own, and no lower in the 3 ms
    before, for the stage has stopped."""
    n = len(voltage)
    names = tuple(f"draw{i}" for i in range(n))
    return RunConditions(
        run=names, session=("benchmark",) * n, condition=names, substrate=("brass",) * n, voltage=voltage,
        frequency=frequency, width=width, thickness=thickness, friction_before=friction,
        switch_off_force=np.full(n, np.nan), drive_duration=np.full(n, 3.0), dwell=np.full(n, 0.003),
        run_order=np.arange(n, dtype=float),
    )  # fmt: skip


def draws(number: int, seed: int = 20250601) -> tuple[ClutchModel, RunConditions, dict[str, FloatArray]]:
    """(model, runs, parameters (1, runs)): V 100-300, DC-10 kHz, w 2-6 mm, preload 0.05-2 N, k +-50 %,
    sigma +-30 %, Cole-Cole +-20 %, force at switch-off between the two ends of the stick-slip."""
    rng = np.random.default_rng(seed)

    def around(centre: float, share: float) -> FloatArray:
        return centre * rng.uniform(1 - share, 1 + share, (1, number))

    width = rng.choice(list(WIDTHS), number)
    thickness = np.array([WIDTHS[w] for w in width]) * 1e-3
    width = width * 1e-3
    preload = np.exp(rng.uniform(np.log(0.05), np.log(2.0), number))
    frequency = np.exp(rng.uniform(np.log(0.1), np.log(1e4), number))
    model = ClutchModel(BENCH, BASE)
    parameters = {
        "contact_stiffness": around(5.4e14, 0.5),
        "roughness_sd": around(2.8e-6, 0.3),
        "kappa_static": around(54.2, 0.2),
        "relaxation_time": around(2.82e-6, 0.2),
        "cole_cole_exponent": around(0.562, 0.2),
        "slip_phase": rng.uniform(0.0, 1.0, (1, number)),
    }
    kinetic = BENCH.friction.film_kinetic.mean, BENCH.friction.base_kinetic.mean
    mass = BENCH.substrates["brass"].density * 0.1 * width * thickness
    friction = preload * sum(kinetic) + 9.81 * mass * kinetic[1]
    voltage = rng.uniform(100.0, 300.0, number)
    return model, conditions(voltage, frequency, width, thickness, friction), parameters
