"""Hide an effect in a simulated campaign, find it through the files alone, extend the law, and measure the gain."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import hexathermal as ht
from hexathermal.simulate.hidden.drawing import draw_campaign
from hexathermal.simulate.hidden.writing import write_campaign


def main() -> None:
    """Let the bench play a trick on us, and see through it."""
    # somebody else makes a campaign of a leg with play in its screw; what is hidden stands beside the folder, not in it
    truth, answer = draw_campaign("finite_volume", np.random.default_rng(5), causes=("backlash",), strength=1.5)
    write_campaign(Path("campaign"), truth, answer)

    # we have the files only, and the law that reads the thermometer T07
    campaign = ht.load_campaign("campaign")
    found = ht.diagnose(campaign, answer.base)
    print(found.sentence)
    print(f"probability {found.probability:.3f}; as likely: {', '.join(found.effects[0].equivalent) or 'nothing else'}")

    # the extended law is a law like any other: it is written, read, and validated on runs that were never fitted
    ht.write_leg_law(found.extended, "extended.toml")
    extended = ht.read_leg_law("extended.toml")
    for name, law in (("law", found.law), ("extended law", extended)):
        rmse = ht.validate_campaign(law, campaign).total.rmse
        print(f"{name}: RMSE {rmse.value * 1e6:.3f} um ({rmse.low * 1e6:.3f} to {rmse.high * 1e6:.3f}) on new runs")

    # what this campaign could have missed, and what to do next
    limits = sorted(found.limits, key=lambda one: one.whole)
    print(f"smallest effect that would be named: {limits[0].cause} of {limits[0].whole * 1e6:.2g} um RMS,")
    print(f"largest that could hide: {limits[-1].cause} of {limits[-1].whole * 1e6:.2g} um RMS")
    print(f"next: {found.experiments[0].words}")

    print(f"hidden was: {', '.join(answer.causes)}, of {answer.strengths[0]:.1f} times the noise")


if __name__ == "__main__":
    main()
