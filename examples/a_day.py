"""A machine's error over a day, hour by hour, with and without correction, and what is left."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import hexathermal as ht
from hexathermal.show.figures import day_figure, save_figure
from hexathermal.simulate.demonstration import demonstrate, largest, save


def main() -> None:
    """Let a machine work for eight hours, and say how far off its platform stands."""
    hexapod = ht.load_hexapod("reference")
    day = demonstrate(hexapod, seed=1)  # a simulated day: the controller knows only what its thermometers read

    hours = day.truth.time / 3600.0
    (shift, turn), (shift_left, turn_left) = largest(day.errors_without), largest(day.errors_with)
    print("hour  state  legs    without correction     with correction")
    print("             K       um        urad         um      urad")
    for hour in range(int(hours[-1]) + 1):
        k = int(np.abs(hours - hour).argmin())
        rise = day.truth.legs[k].mean() - 20.0
        state = "works" if day.truth.working[k] else "rests"
        print(f"{hour:4d}  {state}  {rise:5.2f} {shift[k]:7.2f} {turn[k]:10.2f} {shift_left[k]:11.2f} "
              f"{turn_left[k]:9.2f}")  # fmt: skip
    worst = int(shift.argmax())
    print(f"worst without correction: {shift[worst]:.2f} um after {hours[worst]:.1f} h; "
          f"with correction {shift_left.max():.2f} um at most")  # fmt: skip

    # why it is not nought: the budget of the worst moment, from the causes that the machine's file knows
    pose = day.poses[int(np.linalg.norm(day.errors_without[worst, :, :3], axis=1).argmax())]
    budget = hexapod.error_budget(pose, day.readings[worst])
    spread = ", ".join(f"{axis} {U * 1e6:.2f} um" for axis, U in zip("xyz", budget.expanded()[:3], strict=True))
    print(f"uncertainty of what is left, 95 %: {spread}; in z the largest sources are")
    for one in sorted(budget.contributions, key=lambda item: -item.uncertainty[2])[:3]:
        print(f"  {one.label}: {one.uncertainty[2] * 1e6:.2f} um")

    Path("day").mkdir(exist_ok=True)
    files = save(day, Path("day"))
    files += (save_figure(day_figure(day), "day/day.png"),)
    print("written:", ", ".join(str(file) for file in files))


if __name__ == "__main__":
    main()
