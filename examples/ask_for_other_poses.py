"""Poses that cannot tell two faults apart: the answer holds both names, and the poses that will."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import hexathermal as ht
from hexathermal.learn.machine_proposal import propose_experiment
from hexathermal.simulate.machine.building import virtual_machine
from hexathermal.simulate.machine.campaign_folder import write_machine_campaign
from hexathermal.simulate.machine.parts import PositioningSystem
from hexathermal.simulate.machine.runs import planned_machine_runs, simulate_machine

DRAWN = ht.load_hexapod("reference")


def measured(folder: str, poses: np.ndarray, seed: int) -> ht.Campaign:
    """Measure a machine one of whose joints sits 30 um off its drawing, and which does what its law says else."""
    joints = DRAWN.base_joints.copy()
    joints[3] += [20e-6, -10e-6, 20e-6]
    still = PositioningSystem(frame_shift=0.0, frame_turn=0.0)  # a tracker that is not set up anew
    machine = virtual_machine(replace(DRAWN, base_joints=joints), tracker=still, growth="law")
    plans = planned_machine_runs(machine, seed, identification=1, validation=0, poses=len(poses), given=poses)
    write_machine_campaign(folder, machine, plans, simulate_machine(machine, seed, plans))
    filed = virtual_machine(DRAWN, growth="law").hexapod
    ht.write_hexapod(filed, f"{folder}/hexapod.toml")  # who measures has the drawing
    return ht.load_campaign(folder)


def told(found: ht.MachineDiagnosis) -> str:
    """Return the first name, and those that are as likely."""
    names = [f"{found.effects[0].cause} of {found.effects[0].target}", *found.effects[0].equivalent_places]
    return " or ".join(names) + f" (probability {found.probability:.2f})"


def main() -> None:
    """Ask, be answered with two names, measure what is proposed, ask again."""
    small = np.random.default_rng(1).uniform(-1.0, 1.0, (60, 6)) * [2, 2, 2, 0.1, 0.1, 0.1]  # mm, deg
    campaign = measured("small-poses", small, seed=1)
    found = ht.diagnose(campaign)
    assert isinstance(found, ht.MachineDiagnosis)
    print("about home:", told(found))

    plan = propose_experiment(campaign, found, 40)
    print(plan.words)
    print("first pose to add, mm and deg:", plan.coordinates[0].round(1).tolist())

    again = ht.diagnose(measured("other-poses", np.array(plan.coordinates), seed=2))
    assert isinstance(again, ht.MachineDiagnosis)
    print("as proposed:", told(again))


if __name__ == "__main__":
    main()
