"""hexathermal: Gough-Stewart hexapods when heat moves their platform.

``pose -> leg lengths -> thermal correction of each leg -> forward kinematics -> Cartesian error``

>>> import hexathermal as ht
>>> hexapod = ht.load_hexapod("reference")
>>> pose = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0])       # mm, deg
>>> hexapod.corrected_leg_lengths(pose, [21.5] * 6).shape        # degC, one thermometer a leg
(6,)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from hexathermal import loading as _loading  # noqa: F401 (first: it watches while the others load)
from hexathermal.errors import HexathermalError
from hexathermal.kinematics.forward import ForwardResult, ForwardStatus
from hexathermal.machine import ports as _ports
from hexathermal.machine import shown as _shown
from hexathermal.machine.bodies import Bodies, PoseLimits
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import bundled_hexapods, load_hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.machine.writing import write_hexapod
from hexathermal.poses import Frames, coordinates_from_pose, pose_from_coordinates
from hexathermal.predict import answers as _answers
from hexathermal.predict.one_call import corrected_leg_lengths

if TYPE_CHECKING:
    from hexathermal.compare.comparison import compare_campaign
    from hexathermal.learn.air import refractive_index
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.campaign_dataset import read_run, save_campaign_netcdf
    from hexathermal.learn.campaign_files import load_campaign
    from hexathermal.learn.campaign_laws import identify_campaign, validate_campaign
    from hexathermal.learn.check import check_campaign
    from hexathermal.learn.cleaning import usable_blocks, used_run
    from hexathermal.learn.common import fit_common
    from hexathermal.learn.diagnosing import diagnose
    from hexathermal.learn.diagnosis.result import Diagnosis
    from hexathermal.learn.identification import Identification, identify
    from hexathermal.learn.law import IdentifiedLaw
    from hexathermal.learn.leg_law_files import read_leg_law, write_leg_law
    from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
    from hexathermal.learn.machine_proposal import propose_experiment
    from hexathermal.learn.validation import Validation, validate
    from hexathermal.machine.compliance import Compliance
    from hexathermal.machine.leg_repairs import SensorRepair
    from hexathermal.machine.leg_terms import LegTerm
    from hexathermal.machine.measuring_frame import MeasuringFrame
    from hexathermal.predict.budget import Budget
    from hexathermal.predict.budget_defaults import default_sources
    from hexathermal.predict.budget_inputs import Plates
    from hexathermal.predict.budget_maps import budget_map, pose_grid
    from hexathermal.predict.montecarlo import monte_carlo
    from hexathermal.predict.sources import Source, Sources

_ports.install(Hexapod, _answers)
_shown.show_with(lambda value: str(import_module("hexathermal.show.notebook").html_of(value)))

__version__ = "0.1.0"

_LATER = {
    "Budget": "hexathermal.predict.budget",
    "Campaign": "hexathermal.learn.campaign",
    "Compliance": "hexathermal.machine.compliance",
    "Diagnosis": "hexathermal.learn.diagnosis.result",
    "Identification": "hexathermal.learn.identification",
    "IdentifiedLaw": "hexathermal.learn.law",
    "LegTerm": "hexathermal.machine.leg_terms",
    "MachineDiagnosis": "hexathermal.learn.machine_diagnosis.result",
    "MeasuringFrame": "hexathermal.machine.measuring_frame",
    "Plates": "hexathermal.predict.budget_inputs",
    "SensorRepair": "hexathermal.machine.leg_repairs",
    "Source": "hexathermal.predict.sources",
    "Sources": "hexathermal.predict.sources",
    "Validation": "hexathermal.learn.validation",
    "budget_map": "hexathermal.predict.budget_maps",
    "check_campaign": "hexathermal.learn.check",
    "compare_campaign": "hexathermal.compare.comparison",
    "default_sources": "hexathermal.predict.budget_defaults",
    "diagnose": "hexathermal.learn.diagnosing",
    "fit_common": "hexathermal.learn.common",
    "identify": "hexathermal.learn.identification",
    "identify_campaign": "hexathermal.learn.campaign_laws",
    "load_campaign": "hexathermal.learn.campaign_files",
    "monte_carlo": "hexathermal.predict.montecarlo",
    "pose_grid": "hexathermal.predict.budget_maps",
    "propose_experiment": "hexathermal.learn.machine_proposal",
    "read_leg_law": "hexathermal.learn.leg_law_files",
    "read_run": "hexathermal.learn.campaign_dataset",
    "refractive_index": "hexathermal.learn.air",
    "save_campaign_netcdf": "hexathermal.learn.campaign_dataset",
    "usable_blocks": "hexathermal.learn.cleaning",
    "used_run": "hexathermal.learn.cleaning",
    "validate": "hexathermal.learn.validation",
    "validate_campaign": "hexathermal.learn.campaign_laws",
    "write_leg_law": "hexathermal.learn.leg_law_files",
}
"""Names that are imported on first use: what stands behind them loads SciPy, PyArrow or xarray."""

__all__ = [
    "Bodies",
    "Budget",
    "Campaign",
    "Compliance",
    "Diagnosis",
    "ForwardResult",
    "ForwardStatus",
    "Frames",
    "Hexapod",
    "HexathermalError",
    "Identification",
    "IdentifiedLaw",
    "LegLaw",
    "LegTerm",
    "MachineDiagnosis",
    "MeasuringFrame",
    "PlateLaw",
    "Plates",
    "PoseLimits",
    "SensorRepair",
    "Source",
    "Sources",
    "ThermalModel",
    "Validation",
    "budget_map",
    "bundled_hexapods",
    "check_campaign",
    "compare_campaign",
    "coordinates_from_pose",
    "corrected_leg_lengths",
    "default_sources",
    "diagnose",
    "fit_common",
    "identify",
    "identify_campaign",
    "load_campaign",
    "load_hexapod",
    "monte_carlo",
    "pose_from_coordinates",
    "pose_grid",
    "propose_experiment",
    "read_leg_law",
    "read_run",
    "refractive_index",
    "save_campaign_netcdf",
    "usable_blocks",
    "used_run",
    "validate",
    "validate_campaign",
    "write_hexapod",
    "write_leg_law",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use."""
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_LATER[name]), name)
    return value


def __dir__() -> list[str]:
    """Return all public names, imported or not."""
    return sorted({*globals(), *__all__})
