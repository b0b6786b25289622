"""A machine with a hidden fault: measured, diagnosed through its files alone, extended, and measured again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import hexathermal as ht
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import hexapod_rows
from hexathermal.learn.hexapod_identification import identify_hexapod
from hexathermal.learn.hexapod_validation import validate_hexapod
from hexathermal.simulate.machine.building import virtual_machine
from hexathermal.simulate.machine.campaign_folder import write_machine_campaign
from hexathermal.simulate.machine.runs import planned_machine_runs, simulate_machine


def measured(hexapod: ht.Hexapod, folder: str, seed: int, fitted: int, held: int, filed: ht.Hexapod | None) -> Campaign:
    """Let the virtual machine work, warm up and be measured; heat flows through it, no thermal law is used."""
    machine = virtual_machine(hexapod, seed=7)
    plans = planned_machine_runs(machine, seed, identification=fitted, validation=held, poses=60)
    write_machine_campaign(folder, machine, plans, simulate_machine(machine, seed, plans))
    if filed is not None:  # who measures has the machine's file, and nothing of what it truly is
        ht.write_hexapod(filed, Path(folder) / "hexapod.toml")
    return ht.load_campaign(folder)


def main() -> None:
    """Lose a camera in the drawing, and find it in the poses."""
    # the machine is new: its laws are identified, and nothing else is wrong with it
    new = ht.load_hexapod("reference")
    campaign = measured(new, "new", seed=1, fitted=3, held=1, filed=None)
    filed = identify_hexapod(hexapod_rows(campaign, "identification")).hexapod("as filed")
    print("new machine:", ht.diagnose(campaign, hexapod=filed).sentence)

    # a camera of 60 kg is mounted, 0.2 m above the platform and 50 mm off its middle; the machine's file is not told
    camera = ht.Compliance(leg_compliance=2e-8, payload_mass=60.0, payload_centre=[0.05, 0.0, 0.2])
    loaded = replace(new, compliance=camera)
    found = ht.diagnose(measured(loaded, "loaded", seed=2, fitted=3, held=1, filed=filed))
    print(f"later: {found.sentence}\nprobability {found.probability:.3f}")
    print(f"sag of one leg under all of it, truly: {camera.leg_compliance[0] * 60.0 * 9.80665 * 1e6:.2f} um")

    # the extended machine is a file like any other: controllers, budgets and validations read it
    assert isinstance(found, ht.MachineDiagnosis)
    ht.write_hexapod(found.extended, Path("extended") / "hexapod.toml")
    extended = ht.load_hexapod("extended")

    # measured again: runs that nothing was fitted to, each machine correcting in its turn
    again = measured(loaded, "again", seed=3, fitted=0, held=2, filed=filed)
    scores = {name: validate_hexapod(one, again).total for name, one in (("filed", filed), ("extended", extended))}
    print("measured again, RMS error of the platform after correction:")
    for axis, before in scores["filed"].items():
        unit = "urad" if axis.startswith("r") else "um"
        after = scores["extended"][axis].after
        print(f"  {axis:12}{before.after.value * 1e6:7.2f} -> {after.value * 1e6:5.2f} {unit}")


if __name__ == "__main__":
    main()
