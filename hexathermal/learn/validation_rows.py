"""A law with terms on whole runs: all rows are run through, so that states are right; the usable ones are scored."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign import Block, Campaign
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows, follows_on, run_rows
from hexathermal.learn.validation import Predicted
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_states import LegMemory


def law_on_rows(
    law: IdentifiedLaw, signals: LegSignals, run: str | None = None, before: LegMemory | None = None
) -> Predicted:
    """Return what a law says of all rows of a run, terms and repairs included.

    Parameters
    ----------
    law : IdentifiedLaw
    signals : LegSignals
        As recorded.
    run : str, optional
        Name of the run.
    before : LegMemory, optional
        Of the terms in the runs before, on the same clock; it goes on.
    """
    right = law.repaired(signals, run=run)
    dT = np.column_stack([right.temperature(name) for name in law.sensors])
    variance = law.variance_signals(signals, run=run, before=None if before is None else before.copy())
    return Predicted(dT, law.predict_signals(signals, run=run, before=before), variance)


class RowsPredictor:
    """Predicts usable rows of a campaign's runs from all rows of the same run; the last run is kept.

    Where the runs follow one another on the campaign's clock, the law remembers those before.

    Parameters
    ----------
    law : IdentifiedLaw
    campaign : Campaign
    read : mapping of str to RunRows, optional
        Runs that are in memory already, by their names.
    """

    def __init__(self, law: IdentifiedLaw, campaign: Campaign, read: Mapping[str, RunRows] | None = None) -> None:
        self.law, self.campaign, self._read = law, campaign, read or {}
        self._run, self._time = "", np.zeros(0)
        self._said = Predicted(np.zeros((0, 0)), self._time, self._time)
        self._past: dict[str, LegMemory] = {}

    def __call__(self, block: Block) -> Predicted:
        """Return what the law says of a block's rows."""
        name = block.run.name
        if name != self._run:
            signals = (self._read.get(name) or run_rows(self.campaign, name)).signals
            # blocks count from the run's first row, signals perhaps from the campaign's
            try:
                self._said, self._run = law_on_rows(self.law, signals, name, self._before(name)), name
            except ArgumentError as error:
                raise DataError(f"run {name}: {error}") from None
            self._time = signals.time - signals.time[0]
        at = np.searchsorted(self._time, block.time - 1e-9)
        said = Predicted(self._said.dT[at], self._said.drift[at], self._said.variance[at])
        if not np.isfinite(said.drift).all():
            raise DataError(
                f"run {name}: the law has no prediction from {block.time[~np.isfinite(said.drift)][0]:g} s on: a "
                "signal that its terms read has no values; take runs that hold it"
            )
        return said

    def _before(self, name: str) -> LegMemory:
        """Return what the law remembers when a run begins."""
        if not self._past:
            whole = {name: rows.signals for name, rows in self._read.items()}
            everything = all(run.name in whole for run in self.campaign.runs)
            self._past = memories(self.law, self.campaign, whole if everything else None)
        return self._past[name].copy()


def memories(
    law: IdentifiedLaw, campaign: Campaign, read: Mapping[str, LegSignals] | None = None
) -> dict[str, LegMemory]:
    """Return what a law's terms remember when each run begins; nothing, where runs count from their own first rows.

    Parameters
    ----------
    law : IdentifiedLaw
    campaign : Campaign
    read : mapping of str to LegSignals, optional
        Signals of the runs to go through, where they were read already; by default all are read.
    """
    names = [run.name for run in campaign.runs if read is None or run.name in read]
    if campaign.zero == "run" or not law.terms:
        return {name: law.memory() for name in names}
    found: dict[str, LegMemory] = {}
    memory, last = law.memory(), None
    for name in names:
        signals = run_rows(campaign, name).signals if read is None else read[name]
        memory = memory if follows_on(campaign.zero, last, signals) else law.memory()
        found[name] = memory.copy()
        law.predict_signals(signals, run=name, before=memory)
        last = signals
    return found
