"""`diagnose`: what a model gets wrong on a campaign, of one leg, of a component, or of a whole hexapod."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, overload

from hexathermal.errors import ArgumentError

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.diagnosis.result import Diagnosis
    from hexathermal.learn.law import IdentifiedLaw
    from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
    from hexathermal.machine.hexapod import Hexapod

Progress = Callable[[int, int, str], None]


@overload
def diagnose(
    campaign: Campaign, sensors: Sequence[str], *, law: None = None, progress: Progress | None = None
) -> Diagnosis: ...


@overload
def diagnose(
    campaign: Campaign, sensors: None = None, *, law: IdentifiedLaw, progress: Progress | None = None
) -> Diagnosis: ...


@overload
def diagnose(
    campaign: Campaign, *, hexapod: Hexapod, laws: str | None = None, progress: Progress | None = None
) -> MachineDiagnosis: ...


@overload
def diagnose(
    campaign: Campaign, *, hexapod: Hexapod | None = None, laws: str, progress: Progress | None = None
) -> MachineDiagnosis: ...


@overload
def diagnose(campaign: Campaign, *, progress: Progress | None = None) -> Diagnosis | MachineDiagnosis: ...


def diagnose(
    campaign: Campaign,
    sensors: Sequence[str] | None = None,
    *,
    law: IdentifiedLaw | None = None,
    hexapod: Hexapod | None = None,
    laws: str | None = None,
    progress: Progress | None = None,
) -> Diagnosis | MachineDiagnosis:
    """Return what a model gets wrong on a campaign's measurements, and why.

    The runs for identification are searched; those for validation only tell the gain.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"leg"`` or ``"component"``: a law is diagnosed; of kind ``"hexapod"``: a machine.
    sensors : sequence of str, optional
        Of the law; by default those that `identify_campaign` chooses. Not for a hexapod.
    law : IdentifiedLaw, optional
        A law whose sensors are taken. Not for a hexapod.
    hexapod : Hexapod, optional
        The machine; by default the campaign's own. For a hexapod only.
    laws : str, optional
        ``"kept"`` (default): the legs' laws are those of the machine's file, within the covariance that it states;
        ``"refit"``: they are fitted anew beside every cause. For a hexapod only.
    progress : function, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        An argument belongs to the other kind of campaign.
    DataError
        There is too little data, or the law's sensors have no values.
    ThermalModelError
        A machine has no thermal law.
    CampaignError
        A table is at fault.
    """
    if campaign.kind == "hexapod":
        from hexathermal.learn.machine_diagnosis.diagnosing import diagnose_machine

        if sensors is not None or law is not None:
            raise ArgumentError(
                f"{'sensors' if law is None else 'law'} is for a campaign of one leg or component; a whole machine has "
                "the laws of its hexapod.toml: give hexapod=, or a machine file with other laws"
            )
        return diagnose_machine(campaign, hexapod=hexapod, laws=laws or "kept", progress=progress)
    if hexapod is not None or laws is not None:
        raise ArgumentError(
            f"{'laws' if hexapod is None else 'hexapod'} is for a campaign of a whole hexapod; this one is of kind "
            f"{campaign.kind!r}: give sensors= or law="
        )
    from hexathermal.learn.diagnosis.diagnosing import diagnose as diagnose_law

    return diagnose_law(campaign, sensors, law=law, progress=progress)
