"""The sources that a budget counts where the user names none: one documented value each.

Three kinds: *published* (with the paper), *derived* (from published numbers), *engineering value* (an assumption that a
user should replace by what is known of the machine).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw, ThermalModel
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_plates import Plates, check_plates
from hexathermal.predict.sources import Source, Sources
from hexathermal.predict.temperatures import active_model

RELATIVE_COEFFICIENTS = 0.03
"""Standard uncertainty of A and B as a part of them, where the law brings no covariance. Engineering value."""

LEG_TO_LEG = 0.02
"""How differently legs expand that share one law, identified on one of them. Engineering value."""


BLIND_PLATE_K = 2.0
"""Half-width of the temperature of a plate that nobody measured. Engineering value."""

STATED_PLATE_K = 0.2
"""Half-width of the temperature of a plate that somebody read off a thermometer. Engineering value."""


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
    return Sources((*_sensors(), *_laws(hexapod), *_lengths(), *_plates(hexapod, given), *_geometry()))


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
    shared = model.common_law
    stated = [law.covariance is not None for law in model.legs]
    sources = [_coefficients(model.legs, all(stated), "common" if shared else "independent"), *_terms(model)]
    if shared:
        sources.append(_leg_to_leg(model.legs[0]))
    sources += [
        Source("law residual", "length", 0.35e-6,
               basis="published: mean residual 0.28 um in runs left out (Robert et al.), as that of a normal one"),
        Source("index of air", "growth", 3.4e-8, correlation="common",
               basis="derived: 0.17 ppm of a weather station (0.2 K, 1 hPa, 6 %) over the 5 K of a campaign; it moves "
                     "A and B of all legs alike"),
    ]  # fmt: skip
    return tuple(sources)


def _coefficients(laws: tuple[LegLaw, ...], stated: bool, correlation: str) -> Source:
    """Return the source of the identified coefficients."""
    if not stated:
        values = [np.concatenate([np.abs(law.A), np.abs(law.B)]) * RELATIVE_COEFFICIENTS for law in laws]
        whole = values[0] if correlation == "common" else np.concatenate(values)
        return Source("coefficients", "coefficients", whole, correlation=correlation,
                      basis=f"engineering value: {100 * RELATIVE_COEFFICIENTS:g} % of each, as the law states no "
                            "covariance")  # fmt: skip
    covariances = [np.asarray(law.covariance) for law in laws]
    if correlation == "common" and laws[0].spread is not None:
        # the spread is no error that legs have in common: `leg to leg` counts it
        covariances = [_without(covariances[0], laws[0].spread)]
    return _stated("coefficients", "coefficients", covariances, correlation)


def _without(covariance: FloatArray, spread: FloatArray) -> FloatArray:
    """Return a covariance less the spread that it holds; what numbers of few digits make negative is 0."""
    values, vectors = np.linalg.eigh(covariance - np.diag(np.square(spread)))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _leg_to_leg(law: LegLaw) -> Source:
    """Return by how much legs that share a law differ: what the law tells, else a part of its coefficients."""
    usual = np.concatenate([np.abs(law.A), np.abs(law.B)]) * LEG_TO_LEG
    basis = f"engineering value: legs of one law differ by {100 * LEG_TO_LEG:g} % of it"
    if law.spread is None:
        return Source("leg to leg", "coefficients", usual, basis=basis)
    told = law.spread > 0.0
    basis = "spread between legs of the law" + f"; where it tells none, {basis}" * bool(not told.all())
    return Source("leg to leg", "coefficients", np.where(told, law.spread, usual), basis=basis)


def _terms(model: ThermalModel) -> list[Source]:
    """Return the source of the amplitudes of terms; none where no leg carries any."""
    if not model.has_terms:
        return []
    correlation = "common" if model.common_law else "independent"
    terms = [law.terms for law in (model.legs[:1] if model.common_law else model.legs)]
    if any(not term.covariance.any() for own in terms for term in own):
        values = [np.concatenate([np.zeros(0), *(np.abs(term.amplitudes) for term in own)]) for own in terms]
        basis = f"engineering value: {100 * RELATIVE_COEFFICIENTS:g} % of each, as a term states no covariance"
        sizes = np.concatenate(values) * RELATIVE_COEFFICIENTS
        return [Source("terms of the law", "amplitudes", sizes, correlation=correlation, basis=basis)]
    stated = [_blocks([term.covariance for term in law.terms]) for law in model.legs]
    return [_stated("terms of the law", "amplitudes", stated, correlation)]


def _blocks(matrices: Sequence[FloatArray]) -> FloatArray:
    """Return matrices along the diagonal of one."""
    whole, first = np.zeros((sum(map(len, matrices)),) * 2), 0
    for matrix in matrices:
        whole[first : first + len(matrix), first : first + len(matrix)] = matrix
        first += len(matrix)
    return whole


def _stated(label: str, quantity: str, covariances: Sequence[FloatArray], correlation: str) -> Source:
    """Return the source of numbers whose covariance each leg states."""
    basis = "covariance of the law"
    deviations = [np.sqrt(np.diag(matrix)) for matrix in covariances]
    matrices = [_correlation(C, u) for C, u in zip(covariances, deviations, strict=True)]
    if correlation == "common":
        return Source(label, quantity, deviations[0], correlation="common", within=matrices[0], basis=basis)
    return Source(label, quantity, np.concatenate(deviations), correlation=_blocks(matrices), basis=basis)


def _correlation(C: FloatArray, u: FloatArray) -> FloatArray:
    """Return the correlations of a covariance; ones where a variance is 0."""
    scale = np.divide(1.0, u, out=np.zeros_like(u), where=u > 0.0)
    matrix = C * np.outer(scale, scale)
    np.fill_diagonal(matrix, 1.0)
    return np.asarray(matrix)


def _lengths() -> tuple[Source, ...]:
    """Return the sources of the commanded lengths."""
    return (
        Source("encoder", "length", 0.05e-6, basis="engineering value: 20 to 100 nm within a period of the scale"),
        Source("scale", "scale", 1e-6, basis="engineering value: 1 um/m after calibration"),
        Source.bounded("backlash", "length", 0.3e-6, "arcsine",
                       basis="engineering value: joints outside the loop rest on one side or the other, 0.2 to 2 um "
                             "in all"),
    )  # fmt: skip


def _plates(hexapod: Hexapod, given: Plates) -> tuple[Source, ...]:
    """Return the sources of the plates that the machine has."""
    model = active_model(hexapod)
    plates = (model.platform, model.base)
    known = np.array([0.0 if plate is None else abs(plate.expansion) for plate in plates])
    if not known.any():
        return ()
    blind = np.array([plate is not None and plate.sensor is None for plate in plates])
    there = np.array([plate is not None for plate in plates])
    sources = [
        Source.bounded("plate expansion", "plate expansion", 0.1 * known,
                       basis="engineering value: 10 % of the material's coefficient"),
    ]  # fmt: skip
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
