"""emcee sampling of a problem: independent ensembles, extended until the gate passes or the limit is reached."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import emcee
import numpy as np

from eaclutch.inference import checkpoint as checkpoints
from eaclutch.inference.checkpoint import Checkpoint
from eaclutch.inference.convergence import Diagnostics, Thresholds, diagnose
from eaclutch.inference.moves import Target, moves
from eaclutch.inference.problem import Problem, digest
from eaclutch.inference.start import starting_walkers
from eaclutch.records import FloatArray

BURN_IN = 0.05  # share of the steps after warm-up that is dropped too
NEGLIGIBLE = 30.0  # nats by which a mode is below the best one for its search to have failed


@dataclass(frozen=True)
class SamplerSettings:
    """ensembles, walkers (raised to 4 x parameters where that is more), steps between checks, limit of steps,
    thresholds of the gate, draws that are stored per ensemble, steps before the jump target is fixed (dropped)."""

    ensembles: int = 4
    walkers: int = 24
    check_every: int = 250
    max_steps: int = 20000
    thresholds: Thresholds = field(default_factory=Thresholds)
    stored_draws: int = 500
    warm_up: int = 400

    def walkers_for(self, params: int) -> int:
        walkers = max(self.walkers, 4 * params)
        return walkers + walkers % 2


@dataclass(frozen=True)
class Sampled:
    """A finished run. chain (ensembles, steps, walkers, params) in natural units, without burn-in; log_density
    (ensembles, steps, walkers) in the priors' normal coordinates; evaluations of the likelihood and seconds."""

    problem: Problem
    chain: FloatArray
    log_density: FloatArray
    diagnostics: Diagnostics
    converged: bool
    failures: tuple[str, ...]
    total_steps: int
    evaluations: int
    seconds: float

    @property
    def flat(self) -> FloatArray:
        """All draws (draws, params)."""
        return self.chain.reshape(-1, self.chain.shape[-1])

    @property
    def evaluations_per_second(self) -> float:
        return self.evaluations / self.seconds if self.seconds > 0 else np.nan


def sample(
    problem: Problem,
    settings: SamplerSettings,
    seed: int,
    *,
    checkpoint: Path | None = None,
    progress: Callable[[str], None] = lambda _: None,
    begin: FloatArray | None = None,
) -> Sampled:
    """Sample until converged or at the limit; resume from ``checkpoint`` where it exists. ``begin`` (params,): where
    every ensemble starts its search, in the priors' normal coordinates; default the best of prior draws of its own.

    Each chunk starts from the stored state alone, so an interrupted run and an uninterrupted one are the same
    bit for bit. Raises InputError where the checkpoint belongs to other data, code, priors or parameters.
    """
    started = time.perf_counter()
    fingerprints = {**problem.fingerprints(), "sampler": digest([seed, settings.ensembles, settings.walkers,
                                                                 settings.check_every, settings.warm_up])}  # fmt: skip
    if checkpoint is not None and checkpoint.exists():
        state = checkpoints.load(checkpoint, fingerprints)
        progress(f"{problem.stage}: resuming at step {state.chain.shape[1]}")
    else:
        state = _begin(problem, settings, seed, begin)
    new_evaluations = 0
    while True:
        steps = state.chain.shape[1]
        if steps > 1:
            diagnostics = diagnose(state.chain[:, _burned(steps) :])
            failures = diagnostics.failures(settings.thresholds)
            progress(f"{problem.stage}: step {steps}, {'; '.join(failures) or 'converged'}")
            if not failures or steps >= settings.max_steps:
                break
        before = state.evaluations
        state = _extend(problem, state, min(settings.check_every, max(settings.max_steps - steps, 1)))
        new_evaluations += state.evaluations - before
        if checkpoint is not None:
            checkpoints.save(checkpoint, state, fingerprints)
    burned = _burned(state.chain.shape[1])
    return Sampled(
        problem, problem.priors.from_normal(state.chain[:, burned:]), state.log_density[:, burned:], diagnostics,
        not failures, tuple(failures), steps, new_evaluations, time.perf_counter() - started,
    )  # fmt: skip


def _burned(steps: int) -> int:
    return int(BURN_IN * steps)


def _begin(
    problem: Problem, settings: SamplerSettings, seed: int, begin: FloatArray | None = None
) -> Checkpoint:
    """Search, warm up, fit the jump targets; the state after that is where the kept chain starts."""
    walkers, size = settings.walkers_for(len(problem.priors)), len(problem.priors)
    sequences, warm = np.random.SeedSequence(seed).spawn(settings.ensembles), []
    starts = [
        starting_walkers(problem.log_density, size, walkers, np.random.default_rng(sequence), begin)
        for sequence in sequences
    ]
    best = max(starts, key=lambda start: start.density)
    for sequence, start in zip(sequences, starts, strict=True):
        if start.density < best.density - NEGLIGIBLE:
            rng = np.random.default_rng(sequence)
            start = starting_walkers(problem.log_density, size, walkers, rng, best.mode)
        random: Any = np.random.RandomState(np.random.MT19937(sequence.spawn(1)[0])).get_state()
        target = Target(start.mode, start.root)
        position, density = start.walkers, problem.log_density(start.walkers)
        for _ in range(2):  # the second half of each pass gives the next target
            chain, densities, random = _run(problem, position, density, random, target, settings.warm_up // 2)
            target = Target.of(chain[len(chain) // 2 :].reshape(-1, size))
            position, density = chain[-1], densities[-1]
        evaluations = start.evaluations + settings.warm_up * walkers
        warm.append((position, density, random, target, evaluations))
    return Checkpoint(
        np.stack([w[0] for w in warm])[:, None], np.stack([w[1] for w in warm])[:, None],
        tuple(w[2] for w in warm), np.stack([w[3].centre for w in warm]), np.stack([w[3].root for w in warm]),
        sum(w[4] for w in warm),
    )  # fmt: skip


def _extend(problem: Problem, state: Checkpoint, steps: int) -> Checkpoint:
    ensembles, _, walkers, _ = state.chain.shape
    parts = [
        _run(problem, state.chain[i, -1], state.log_density[i, -1], state.random_states[i],
             Target(state.centres[i], state.roots[i]), steps)
        for i in range(ensembles)
    ]  # fmt: skip
    return replace(
        state,
        chain=np.concatenate([state.chain, np.stack([p[0] for p in parts])], axis=1),
        log_density=np.concatenate([state.log_density, np.stack([p[1] for p in parts])], axis=1),
        random_states=tuple(p[2] for p in parts),
        evaluations=state.evaluations + ensembles * steps * walkers,
    )


def _run(
    problem: Problem, position: FloatArray, density: FloatArray, random: Any, target: Target, steps: int
) -> tuple[FloatArray, FloatArray, tuple]:
    """One ensemble: chain (steps, walkers, params), log density (steps, walkers), the generator's state after it."""
    mixture = moves(target, [problem.priors.names.index(name) for name in problem.redrawn])
    sampler = emcee.EnsembleSampler(*position.shape, problem.log_density, moves=mixture, vectorize=True)
    begin = emcee.State(position, log_prob=density, random_state=random)
    end = sampler.run_mcmc(begin, steps, skip_initial_state_check=True)
    return sampler.get_chain(), sampler.get_log_prob(), end.random_state
