"""The paper from bench to correction: measure a leg, identify and validate its law, correct a machine with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import hexathermal as ht
from hexathermal.simulate.bench.bench import Bench, planned_runs, simulate_bench
from hexathermal.simulate.bench.campaign_folder import write_campaign

PUBLISHED = {"A": 1.99, "B": 1.09}
"""Robert et al., eq. (8), thermocouple 7 [um/m/K]."""


def main() -> None:
    """Measure, check, identify every single sensor and every pair, validate, apply, correct."""
    # 1. the bench: seventeen thermocouples, three interferometers, 8 runs to identify and 3 never fitted (simulated)
    bench = replace(Bench(), interval=30.0)
    plans = planned_runs(bench, seed=1)
    write_campaign("campaign", bench, plans, simulate_bench(bench, 1, plans))
    campaign = ht.load_campaign("campaign")

    # 2. what the data are worth, before anything is fitted
    check = ht.check_campaign(campaign)
    rows, used = sum(run.record.rows for run in check.runs), sum(run.record.used for run in check.runs)
    cosine = {one.sensor: one.r for one in check.separability}["T07"]
    print(f"{len(check.runs)} runs, {used} of {rows} rows usable; noise {1e3 * np.median(check.sensor_noise):.0f} mK")
    print(f"A and B of T07 are {'told apart' if cosine < 0.97 else 'hardly told apart'} (cosine {cosine:.2f})")

    # 3. 17 single sensors and 136 pairs, each judged on runs left out of its fit
    found = ht.identify_campaign(campaign)
    single, pair = (found.ranked.best(size) for size in (1, 2))
    for k in (single, pair):
        print(f"best of its size: {' + '.join(found.ranked.names[k]):10} RMSE on runs left out "
              f"{found.ranked.left_out.rmse[k] * 1e6:.3f} um")  # fmt: skip
    print(f"kept: {' + '.join(found.law.sensors)} - {found.choice.reason}")

    # 4. the law of the paper's thermocouple, beside the published one
    law = ht.identify_campaign(campaign, "T07").law
    for name, value, u in zip("AB", law.coefficients * 1e6, law.standard_uncertainty * 1e6, strict=True):
        print(f"{name} = {value:.2f} +- {1.96 * u:.2f} um/m/K (95 %), published {PUBLISHED[name]:.2f}")

    # 5. the proof: runs that were never fitted
    proof = ht.validate_campaign(law, campaign)
    total = proof.total
    print(f"validation: the law {proof.verdict.value}; largest drift {total.drift_largest * 1e6:.2f} um, residual "
          f"{total.linf.value * 1e6:.2f} um (paper: 7.81, 1.28)")  # fmt: skip
    print(f"mean {total.drift_mean * 1e6:.2f} -> {total.mean.value * 1e6:.2f} um (paper: 2.50 -> 0.28), "
          f"{100 * total.mean_reduction.value:.0f} % less")  # fmt: skip

    # 6. a machine whose six legs carry it: a file that controllers, budgets and the command line read
    reference = ht.load_hexapod("reference")
    assert reference.thermal is not None
    thermal = ht.ThermalModel(law.leg_law(), reference.thermal.platform, reference.thermal.base, 20.0, (10.0, 35.0))
    ht.write_hexapod(replace(reference, name="with our law", thermal=thermal), "machine/hexapod.toml")
    hexapod = ht.load_hexapod("machine")

    # 7. and it corrects
    pose = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0], hexapod=hexapod)
    temps = [21.5, 21.7, 22.0, 22.4, 22.1, 21.8]
    correction = hexapod.corrected_leg_lengths(pose, temps) - hexapod.inverse_kinematics(pose)
    print("correction of the six legs [um]:", ", ".join(f"{value * 1e6:.2f}" for value in correction))
    budget = hexapod.error_budget(pose, temps)
    print(f"height of the platform: drift {budget.uncorrected[2] * 1e6:.2f} um, with correction "
          f"{budget.remaining[2] * 1e6:.2f} +- {budget.expanded()[2] * 1e6:.2f} um (95 %)")  # fmt: skip


if __name__ == "__main__":
    main()
