"""The sources that a budget counts where the user names none: one documented value each.

Three kinds: *published* (with the paper), *derived* (from published numbers), *engineering value* (an assumption that a
user should replace by what is known of the machine).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hexathermal.machine.compliance import Compliance
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.thermal import LegLaw, ThermalModel
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_plates import Plates, check_plates
from hexathermal.predict.leg_drift import DIRECTION, between_reversals
from hexathermal.predict.sources import Source, Sources
from hexathermal.predict.temperatures import active_model

RELATIVE_COEFFICIENTS = 0.03
"""Standard uncertainty of A and B as a part of them, where the law brings no covariance. Engineering value."""

USUAL_BACKLASH = 0.3e-6
"""Half width of a leg's backlash of which its law tells nothing [m]. Engineering value."""

LEG_TO_LEG = 0.02
"""How differently legs expand that share one law, identified on one of them. Engineering value."""


RELATIVE_EXPANSION = 0.1
"""Half-width of a plate's expansion as a part of it, where its law states no uncertainty. Engineering value."""

RELATIVE_COMPLIANCE = 0.1
"""Standard uncertainty of a leg's compliance as a part of it, where none is stated. Engineering value."""

RELATIVE_MASS = 0.01
"""Standard uncertainty of the payload as a part of it, where none is stated. Engineering value."""

PAYLOAD_CENTRE = 5e-3
"""Standard uncertainty [m] of the payload's centre of mass, where none is stated. Engineering value."""

BLIND_PLATE_K = 2.0
"""Half-width of the temperature of a plate that nobody measured. Engineering value."""

STATED_PLATE_K = 0.2
"""Half-width of the temperature of a plate that somebody read off a thermometer. Engineering value."""


LAW_COVARIANCE = "covariance of the law"


def default_sources(hexapod: Hexapod, plates: Plates | None = None) -> Sources:
    """Return the sources of a machine, with documented values.

    Every one can be left out (`Sources.without`), changed (`Sources.changed`) or joined by others (`Sources.plus`).
    What a machine does not have (a plate without a law, a plate with a thermometer) has no source.

    Parameters
    ----------
    hexapod : Hexapod
    plates : Plates, optional
        A plate whose temperature is stated there is uncertain by a thermometer, not by the guess that stands for it.

    Returns
    -------
    Sources

    Raises
    ------
    ThermalModelError
        The machine has no thermal law.

    Examples
    --------
    >>> import hexathermal as ht
    >>> default_sources(ht.load_hexapod("reference")).labels[:3]
    ('sensor noise', 'cold junction', 'sensor gain')
    """
    given = Plates() if plates is None else plates
    check_plates(given)
    load = () if hexapod.compliance is None else _load(hexapod.compliance)
    laws = _laws(between_reversals(hexapod))
    return Sources(
        (
            *_sensors(),
            *laws,
            *_lengths(),
            _backlash(active_model(hexapod)),
            *_plates(hexapod, given),
            *load,
            *_geometry(),
        )
    )


def _sensors() -> tuple[Source, ...]:
    """Return the sources of the thermometers."""
    return (
        Source("sensor noise", "temperature", 0.010,
               basis="engineering value: 6 to 14 mK are seen on machine tools"),
        Source("cold junction", "temperature", 0.1, correlation="common",
               basis="engineering value: the thermocouples' common reference junction drifts by 0.05 to 0.2 K"),
        Source("sensor gain", "gain", 0.004, basis="class 1 thermocouple, 0.4 %; offsets vanish against the reference"),
        Source("sensor contact", "contact", 0.03,
               basis="engineering value: a taped sensor misses 2 to 10 % of the difference to the air; the law holds "
                     "the part that was there when it was identified"),
        Source.bounded("reference temperature", "reference temperature", 0.2,
                       basis="engineering value: the calibration's temperature is known within 0.2 K"),
    )  # fmt: skip


def _laws(hexapod: Hexapod) -> tuple[Source, ...]:
    """Return the sources of the legs' laws."""
    model = active_model(hexapod)
    sources = [_coefficients(model), *_terms(model), *_leg_to_leg(model)]
    sources += [
        Source("law residual", "length", 0.35e-6,
               basis="published: mean residual 0.28 um in runs left out (Robert et al.), as that of a normal one"),
        Source("index of air", "growth", 3.4e-8, correlation="common",
               basis="derived: 0.17 ppm of a weather station (0.2 K, 1 hPa, 6 %) over the 5 K of a campaign; it moves "
                     "A and B of all legs alike"),
    ]  # fmt: skip
    return tuple(sources)


def families(model: ThermalModel) -> tuple[int, ...]:
    """Return for each leg the first leg, from 0, that shares its A and B: what is wrong with them is wrong with all.

    Terms are not looked at: a term that one leg has alone does not make its coefficients its own.
    """
    own = [LegLaw(law.sensors, law.A, law.B, law.covariance, law.campaign, (), law.spread) for law in model.legs]
    return tuple(next(k for k, other in enumerate(own) if other == law) for law in own)


def _coefficients(model: ThermalModel) -> Source:
    """Return the source of the identified coefficients: common to legs that share a law, independent of other legs."""
    label, laws, kin = "coefficients", model.legs, families(model)
    guess = f"engineering value: {100 * RELATIVE_COEFFICIENTS:g} % of each, as the law states no covariance"
    if all(law.covariance is None for law in laws):
        values = [np.concatenate([np.abs(law.A), np.abs(law.B)]) * RELATIVE_COEFFICIENTS for law in laws]
        if len(set(kin)) == 1:
            return Source(label, label, values[0], correlation="common", basis=guess)
        if len(set(kin)) == 6:
            return Source(label, label, np.concatenate(values), basis=guess)
    covariances = [_covariance(law, shared=kin.count(kin[leg]) > 1) for leg, law in enumerate(laws)]
    if len(set(kin)) == 1:
        return _stated(label, label, covariances, "common")
    basis = _basis({law.covariance is not None for law in laws}, guess)
    if len(set(kin)) == 6:
        return _stated(label, label, covariances, "independent", basis)
    deviations = [np.sqrt(np.diag(matrix)) for matrix in covariances]
    ends = np.cumsum([0, *map(len, deviations)])
    whole = np.zeros((ends[-1], ends[-1]))
    for a in range(6):
        for b in (b for b in range(6) if kin[b] == kin[a]):
            whole[ends[a] : ends[a + 1], ends[b] : ends[b + 1]] = _correlation(covariances[a], deviations[a])
    return Source(label, label, np.concatenate(deviations), correlation=_ones(whole), basis=basis)


def _basis(stated: set[bool], guess: str) -> str:
    """Return where uncertainties come from that all, none or some of the numbers state."""
    return LAW_COVARIANCE if stated == {True} else f"{LAW_COVARIANCE}; else {guess}" * (True in stated) or guess


def _covariance(law: LegLaw, shared: bool) -> FloatArray:
    """Return the covariance of A and B that counts as theirs.

    Where legs share the law its spread between legs is no error that they have in common: `leg to leg` counts it.
    """
    if law.covariance is None:
        return np.diag(np.square(np.concatenate([law.A, law.B]) * RELATIVE_COEFFICIENTS))
    if shared and law.spread is not None:
        return _without(law.covariance, law.spread)
    return law.covariance


def _without(covariance: FloatArray, spread: FloatArray) -> FloatArray:
    """Return a covariance less the spread that it holds; what numbers of few digits make negative is 0."""
    values, vectors = np.linalg.eigh(covariance - np.diag(np.square(spread)))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _leg_to_leg(model: ThermalModel) -> list[Source]:
    """Return by how much legs that share a law differ: what the law tells, else a part of its coefficients.

    A leg with a law of its own was identified itself, and differs from no other.
    """
    kin = families(model)
    shared = [kin.count(first) > 1 for first in kin]
    if not any(shared):
        return []
    guess = f"engineering value: legs of one law differ by {100 * LEG_TO_LEG:g} % of it"
    values, told = [], []
    for law, among in zip(model.legs, shared, strict=True):
        usual = np.concatenate([np.abs(law.A), np.abs(law.B)]) * LEG_TO_LEG
        known = np.zeros(len(usual), dtype=bool) if law.spread is None else law.spread > 0.0
        values.append(among * np.where(known, 0.0 if law.spread is None else law.spread, usual))
        told.append(known)
    spoken = np.concatenate([own for own, among in zip(told, shared, strict=True) if among])
    basis = "spread between legs of the law" + f"; where it tells none, {guess}" * bool(not spoken.all())
    whole = values[0] if len(set(kin)) == 1 else np.concatenate(values)
    return [Source("leg to leg", "coefficients", whole, basis=basis if spoken.any() else guess)]


def _terms(model: ThermalModel) -> list[Source]:
    """Return the source of the amplitudes of terms; none where no leg carries any.

    Terms that all legs share are wrong in all alike; a term without a covariance counts as wrong by a part of it.
    """
    if not model.has_terms:
        return []
    common = model.common_law
    guess = f"engineering value: {100 * RELATIVE_COEFFICIENTS:g} % of each, as a term states no covariance"
    basis = _basis({bool(term.covariance.any()) for law in model.legs for term in law.terms}, guess)
    matrices = [_blocks([_amplitudes(term) for term in law.terms]) for law in model.legs]
    return [_stated("terms of the law", "amplitudes", matrices, "common" if common else "independent", basis)]


def _amplitudes(term: LegTerm) -> FloatArray:
    """Return the covariance of a term's amplitudes, stated or guessed."""
    guessed = np.diag(np.square(term.amplitudes * RELATIVE_COEFFICIENTS))
    return term.covariance if term.covariance.any() else guessed


def _blocks(matrices: Sequence[FloatArray]) -> FloatArray:
    """Return matrices along the diagonal of one."""
    whole, first = np.zeros((sum(map(len, matrices)),) * 2), 0
    for matrix in matrices:
        whole[first : first + len(matrix), first : first + len(matrix)] = matrix
        first += len(matrix)
    return whole


def _stated(
    label: str, quantity: str, covariances: Sequence[FloatArray], correlation: str, basis: str = LAW_COVARIANCE
) -> Source:
    """Return the source of numbers whose covariance each leg states."""
    deviations = [np.sqrt(np.diag(matrix)) for matrix in covariances]
    matrices = [_correlation(C, u) for C, u in zip(covariances, deviations, strict=True)]
    if correlation == "common":
        return Source(label, quantity, deviations[0], correlation="common", within=matrices[0], basis=basis)
    return Source(label, quantity, np.concatenate(deviations), correlation=_blocks(matrices), basis=basis)


def _correlation(C: FloatArray, u: FloatArray) -> FloatArray:
    """Return the correlations of a covariance; ones where a variance is 0."""
    scale = np.divide(1.0, u, out=np.zeros_like(u), where=u > 0.0)
    return _ones(C * np.outer(scale, scale))


def _ones(matrix: FloatArray) -> FloatArray:
    """Return a matrix with ones on its diagonal."""
    np.fill_diagonal(matrix, 1.0)
    return matrix


def _lengths() -> tuple[Source, ...]:
    """Return the sources of the commanded lengths."""
    return (
        Source("encoder", "length", 0.05e-6, basis="engineering value: 20 to 100 nm within a period of the scale"),
        Source("scale", "scale", 1e-6, basis="engineering value: 1 um/m after calibration"),
    )  # fmt: skip


def _backlash(model: ThermalModel) -> Source:
    """Return the source of the backlash: a pose may be reached from either side.

    Of a leg whose law holds the step at a reversal, half of it; of others an engineering value.
    """
    told = [[abs(float(term.amplitudes[0])) for term in law.terms if term.shape == DIRECTION] for law in model.legs]
    half = np.array([0.5 * sum(own) if own else USUAL_BACKLASH for own in told])
    known = [str(leg) for leg, own in enumerate(told, start=1) if own]
    basis = "engineering value: joints outside the loop rest on one side or the other, 0.2 to 2 um in all"
    if known:
        of_laws = f"half the step at a reversal that the law of leg {', '.join(known)} holds"
        basis = of_laws if len(known) == len(told) else f"{of_laws}; of the others {basis}"
    return Source.bounded("backlash", "length", half if known else USUAL_BACKLASH, "arcsine", basis=basis)


def _plates(hexapod: Hexapod, given: Plates) -> tuple[Source, ...]:
    """Return the sources of the plates that the machine has."""
    model = active_model(hexapod)
    plates = (model.platform, model.base)
    known = np.array([0.0 if plate is None else abs(plate.expansion) for plate in plates])
    told = np.array(
        [np.nan if plate is None or plate.expansion_std is None else plate.expansion_std for plate in plates]
    )
    if not (known.any() or np.nan_to_num(told).any()):
        return ()
    blind = np.array([plate is not None and plate.sensor is None for plate in plates])
    there = np.array([plate is not None for plate in plates])
    sources = []
    if np.isnan(told).any() and known[np.isnan(told)].any():
        sources.append(
            Source.bounded("plate expansion", "plate expansion", RELATIVE_EXPANSION * known * np.isnan(told),
                           basis="engineering value: 10 % of the material's coefficient")
        )  # fmt: skip
    if not np.isnan(told).all():
        basis = "standard uncertainty that the plate's law states"
        sources.append(Source("identified plate expansion", "plate expansion", np.nan_to_num(told), basis=basis))
    if blind.any():
        stated = np.array([told is not None for told in (given.platform_degC, given.base_degC)]) & blind
        half_width = np.where(stated, STATED_PLATE_K, BLIND_PLATE_K * blind)
        sources.append(
            Source.bounded("plate temperature", "plate temperature", half_width, basis=_plate_basis(blind, stated))
        )
    sources.append(
        Source("plate gradient", "plate gradient", 0.5 * there[:, None] * np.ones(3),
               basis="engineering value: 0.5 K/m in every direction")
    )  # fmt: skip
    return tuple(sources)


def _load(own: Compliance) -> tuple[Source, ...]:
    """Return the sources of a payload and of the legs that give way to it."""
    known, told = own.leg_compliance, own.leg_compliance_std
    alike = len({*known.tolist()}) == 1 and (told is None or len({*told.tolist()}) == 1)
    mass, centre = own.payload_mass_std, own.payload_centre_std
    stated = "standard uncertainty that the machine's file states"
    usual = f"engineering value: {100 * RELATIVE_COMPLIANCE:g} % of it; the same for all where legs are alike"
    return (
        Source("leg compliance", "compliance", RELATIVE_COMPLIANCE * known if told is None else told,
               correlation="common" if alike else "independent", basis=usual if told is None else stated),
        Source("payload", "payload mass", RELATIVE_MASS * abs(own.payload_mass) if mass is None else mass,
               basis=f"engineering value: {100 * RELATIVE_MASS:g} % of it" if mass is None else stated),
        Source("centre of the payload", "payload centre", PAYLOAD_CENTRE if centre is None else centre,
               basis=f"engineering value: {1e3 * PAYLOAD_CENTRE:g} mm" if centre is None else stated),
    )  # fmt: skip


def _plate_basis(blind: npt.NDArray[np.bool_], stated: npt.NDArray[np.bool_]) -> str:
    """Return where the uncertainty of the plates' temperatures comes from."""
    guess = f"a plate without a thermometer is taken at the legs' mean temperature within {BLIND_PLATE_K:g} K"
    read = f"a stated plate temperature holds within {STATED_PLATE_K:g} K, as a thermometer tells it"
    words = [read] * bool(stated.any()) + [guess] * bool((blind & ~stated).any())
    return f"engineering value: {'; '.join(words)}"


def _geometry() -> tuple[Source, ...]:
    """Return the sources of the joints' positions."""
    basis = "engineering value: joint centres are known to 1 um in each coordinate after calibration"
    return (
        Source("base joint position", "base joints", 1e-6, basis=basis),
        Source("platform joint position", "platform joints", 1e-6, basis=basis),
    )
