"""What the other thermometers foretell of one: a second residual (parity) that tells a sensor's fault from the part's.

``T_b = P c + bias_b(t) + white``: P are the leading profiles of the other thermometers. What is left, the parity, is
the sensor's own: noise, a slow bias, or heat that no other sees.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.along_leg import smooth_along
from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.parity_windows import PARITY_WINDOW_S, parity_windows
from hexathermal.learn.diagnosis.smoothing import leading_profiles, smoothed
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

FEWEST_OTHERS = 4
"""Other thermometers that are needed to foretell one."""

FEWEST_DOUBTING = 5
"""Others that are needed for the null to doubt a thermometer by them: fewer show a fault of it, but what they foretell
of a sound one is so rough that any misfit could be its error."""

MOST_PROFILES, MOST_LOOSE = 10, 6
"""Profiles of the others where places along the leg foretell their weights, and where nothing does."""

LOOSE = 10.0
"""Prior spread of a weight of which nothing is known."""

WIDER = 1.2
"""Weights may be so much farther from the smooth profile than those of the thermometers nearby are."""

BIAS_K = 0.05
"""Slow bias of a thermometer that weights are learnt beside [K]."""

AIR_SHARE, TIGHT_SHARE = 0.3, 0.1
"""Prior size of the air's share in a sound thermometer; and where one that was never on its part is the other case."""

MOST_SHARE = 0.95
"""Largest share of the air in a reading in which something of its place is left."""

Parity = Callable[["SensorModel"], tuple[FloatArray, FloatArray]]
"""From the model of a sensor to columns in its parity, shape (m, k), and their sizes, shape (k,)."""

ROUNDING_K = 1e-7
"""Readings that differ by less are one: they are recorded in coarser steps."""

FEWEST_ROWS = 10
SLOW_PARITY_S = 1800.0
"""The parity that goes with the law is smoothed over so long: what is quicker is noise of readings."""


def part_of(ratio: float) -> float:
    """Return the share s of the air in a reading, from its ratio ``s / (1 - s)`` to that of the part.

    >>> part_of(0.25), part_of(-0.1)
    (0.2, -0.1)
    """
    return ratio / (1.0 + max(ratio, 0.0))


@dataclass(frozen=True)
class Shown:
    """What the parity of a thermometer shows of a fault.

    Attributes
    ----------
    gain : float
        Log evidence less that without the fault.
    amplitude, uncertainty : float
        Of the fault's last column, and its standard uncertainty.
    amplitudes : tuple of float
        Of all its columns.
    """

    gain: float
    amplitude: float
    uncertainty: float
    amplitudes: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class SensorModel:
    """One thermometer against the others.

    Attributes
    ----------
    view : View
    sensor : str
    unasked : tuple of str
        Others that are not asked, since what is wrong with them would be found in this one.
    contact : float
        Prior size of the air's share in what it reads.
    """

    view: View
    sensor: str
    unasked: tuple[str, ...] = ()
    contact: float = AIR_SHARE

    @cached_property
    def tight(self) -> SensorModel:
        """The same thermometer, thought to let in less of the air."""
        return replace(self, contact=TIGHT_SHARE)

    @property
    def placed(self) -> bool:
        """Whether places along the part foretell the others' weights before anything is learnt."""
        return bool(self._placed)

    @property
    def others(self) -> tuple[str, ...]:
        """The other thermometers."""
        return tuple(name for name in self.view.sensors if name not in (self.sensor, *self.unasked))

    @cached_property
    def profiles(self) -> list[FloatArray]:
        """Leading profiles of the others in all rows of each run, shape (n, k)."""
        return [table @ self.basis for table in self.view.tables(self.others)]

    @cached_property
    def own(self) -> list[FloatArray]:
        """The sensor's smoothed temperature in all rows of each run [K]."""
        return [signals.dT[self.sensor] for signals in self.view.signals]

    @cached_property
    def spoken_for(self) -> bool:
        """Whether it reads what the others tell and nothing besides, as where they were put in its place."""
        own, told = self.means(self.own), self.means(self.profiles)
        left = own - told @ np.linalg.lstsq(told, own, rcond=None)[0]
        return bool(np.abs(left).max() < ROUNDING_K)

    @cached_property
    def basis(self) -> FloatArray:
        """Weights of the others in each leading profile, shape (s, k)."""
        count = len(self.others)
        most = min(MOST_PROFILES, count - 1) if self._placed else min(MOST_LOOSE, max(1, count // 2))
        return leading_profiles(self.view.tables(self.others), most)

    @cached_property
    def _placed(self) -> tuple[str, ...]:
        """The others whose places are stated; none where there are too few, or this sensor's own is not."""
        places = self.view.positions
        known = tuple(name for name in self.others if name in places)
        return known if self.sensor in places and len(known) >= FEWEST_OTHERS else ()

    @cached_property
    def expected(self) -> tuple[FloatArray, FloatArray]:
        """What the profile along the leg lets expect of the weights, and its spread, shape (k,) each.

        Without stated places nothing is expected: zero, with a spread of all that weights may be.
        """
        V, known, places = self.basis, self._placed, self.view.positions
        if not known:
            return np.zeros(V.shape[1]), np.full(V.shape[1], LOOSE)
        x = np.array([places[name] for name in known])
        rest = np.arange(len(known))
        rows = [self.others.index(name) for name in known]
        at = np.array([places[self.sensor]])
        told, spread = smooth_along(x, V[rows], rest, at)
        return told[0], WIDER * spread[0]

    def weights(
        self,
        rows: list[slice] | None = None,
        behind: list[FloatArray] | None = None,
    ) -> FloatArray:
        """Return the weights of the leading profiles that foretell the sensor, shape (k,).

        Parameters
        ----------
        rows : list of slice, optional
            Of each run, to learn from; by default all.
        behind : list of array, optional
            Profiles late, see `behind`, where the sensor follows what the weights foretell late.
        """
        chosen = [slice(None)] * len(self.own) if rows is None else rows
        count = sum(len(own[part]) for own, part in zip(self.own, chosen, strict=True))
        centre, spread = self.expected
        if count < FEWEST_ROWS:
            return centre if np.all(spread < LOOSE) else self.weights(behind=behind)
        profiles = self.profiles if behind is None else behind
        M, z = np.zeros((len(centre), len(centre))), np.zeros(len(centre))
        for run, part in enumerate(chosen):
            if part.stop == 0:
                continue
            if part == slice(None) and behind is None:
                own = self._products[run]
            else:
                own = _products(profiles[run][part], self.own[run][part])
            M += own[0]
            z += own[1]
        return self._solved(M, z, centre, spread)

    def weights_beside_air(self, share: float) -> FloatArray:
        """Return the weights of the leading profiles where the sensor reads a share of the air, always, shape (k,).

        ``T = (1 - share) P c + share T_air``: the more of the air, the less its readings tell of c.
        """
        centre, spread = self.expected
        M, own = (np.sum(each, axis=0) for each in zip(*self._products, strict=True))
        z = own - share * self._product_of_air
        return self._solved((1.0 - share) ** 2 * M, (1.0 - share) * z, centre, spread)

    @cached_property
    def _product_of_air(self) -> FloatArray:
        """Products of the profiles with the air, in all runs."""
        airs = self.view.airs
        assert airs is not None  # looked at before
        return np.asarray(sum(P.T @ air for P, air in zip(self.profiles, airs, strict=True)))

    def _solved(self, M: FloatArray, z: FloatArray, centre: FloatArray, spread: FloatArray) -> FloatArray:
        """Return weights, by products of rows, that are expected about `centre` with a spread, shape (k,) each."""
        left, together = z - M @ centre, self._together
        return np.asarray(centre + np.linalg.solve(M / together + np.diag(1.0 / spread**2), left / together))

    @cached_property
    def _together(self) -> float:
        """Variance of what rows tell of weights: neighbours share the slow bias, so many of them count as one."""
        return max(1.0, PARITY_WINDOW_S / self.view.sampling) * BIAS_K**2

    def behind(self, late: tuple[float, ...]) -> list[FloatArray]:
        """Return the profiles in all rows of each run behind low passes of these time constants [s]."""
        return self.view.rows.behind(self.profiles, late)

    @cached_property
    def _products(self) -> list[tuple[FloatArray, FloatArray]]:
        """Products of each run's profiles with themselves and with the sensor."""
        return [_products(P, y) for P, y in zip(self.profiles, self.own, strict=True)]

    def sensor_weights(self, weights: FloatArray) -> dict[str, float]:
        """Return what weights of the profiles are for each other sensor."""
        return dict(zip(self.others, (self.basis @ weights).tolist(), strict=True))

    def foretold(self, weights: FloatArray | None = None) -> list[FloatArray]:
        """Return what the others foretell in all rows of each run, by some weights, or those learnt from all rows."""
        own = self.weights() if weights is None else weights
        return [p @ own for p in self.profiles]

    @cached_property
    def innovation(self) -> FloatArray:
        """The parity and its slow part in windows of the drift, shape (n, 2) [K]: the law may believe them or not."""
        return self.view.windows_zeroed(self.doubted)

    @cached_property
    def doubted(self) -> list[FloatArray]:
        """The parity and its slow part in all rows of each run, shape (n, 2) [K]."""
        found = []
        for signals, own, told in zip(self.view.signals, self.own, self._told_beside_air, strict=True):
            slow = smoothed(signals.time, (own - told)[:, None], SLOW_PARITY_S)[:, 0]
            found.append(np.column_stack([own - told, slow]))
        return found

    @cached_property
    def _told_beside_air(self) -> list[FloatArray]:
        """What the others and the room's air foretell in all rows of each run [K]: a contact lets some of it in.

        Else the room, which a station reads with less noise, would stand for a better reading of a thermometer that the
        air reaches.
        """
        air = self.view.airs
        if air is None:
            return self.foretold()
        profiles = [np.column_stack(both) for both in zip(self.profiles, air, strict=True)]
        centre, spread = np.append(self.expected[0], 0.0), np.append(self.expected[1], AIR_SHARE)
        own = [_products(P, y) for P, y in zip(profiles, self.own, strict=True)]
        weights = self._solved(np.sum([M for M, _ in own], axis=0), np.sum([z for _, z in own], axis=0), centre, spread)
        return [P @ weights for P in profiles]

    def means(self, values: list[FloatArray]) -> FloatArray:
        """Return means over the parity's windows, run after run."""
        return parity_windows(self.view).means(values)

    @cached_property
    def channel(self) -> Channel:
        """The sensor's temperature in the parity's windows."""
        told = [p @ self.expected[0] for p in self.profiles]
        return parity_windows(self.view).channel(self.means(self.own) - self.means(told))

    @cached_property
    def X(self) -> FloatArray:
        """The others' profiles in the parity's windows, and the air, which any imperfect contact lets in."""
        profiles, air = self.means(self.profiles), self.view.airs
        return profiles if air is None else np.column_stack([profiles, self.means(air)])

    @cached_property
    def sd(self) -> FloatArray:
        """Priors of the coefficients of `X`: of the profiles as expected, of the air loose."""
        spread = self.expected[1]
        return np.concatenate([spread, np.full(self.X.shape[1] - len(spread), self.contact)])

    @cached_property
    def null(self) -> tuple[Levels, float]:
        """Noise and evidence of the parity with nothing hidden in it."""
        return self.channel.fitted(self.X, self.sd)

    def beyond(self, others: Iterable[Levels]) -> float:
        """Return the log evidence of the parity for its own slow noise, less that for the likeliest of others'."""
        own, value = self.null
        theirs = (replace(own, slow=min(one.slow, own.slow), slow_time=one.slow_time) for one in others)
        return value - max((self.channel.evidence(self.X, self.sd, one) for one in theirs), default=value)

    @cached_property
    def bias(self) -> float:
        """Slow bias of the sensor, RMS [K]: that of its parity, or what all others leave of each run, if that is less.

        Their weights, `N(0, 1)`, are learnt from the other runs beside a bias of `BIAS_K`; each run counts from its
        mean. A part of many lumps is more than few profiles tell, and what these leave is no bias of a sensor.
        """
        run, air = self.channel.run, self.X[:, self.basis.shape[1] :]
        everything = np.column_stack([self.means(self.own), self.means(self.view.tables(self.others)), air])
        table = _beside_means(everything, run)
        own, X = table[:, 0], table[:, 1:]
        left, _ = self.channel.with_y(own).left_out(X, np.ones(X.shape[1]), Levels(BIAS_K, 0.0, 0.0, 0.0))
        return min(self.null[0].slow, float(np.sqrt((left**2).mean())))

    @cached_property
    def _displaced(self) -> float:
        """Evidence of the parity where the sensor sits at another place than stated, as exchanged plugs do."""
        spread = np.where(np.arange(len(self.sd)) < len(self.expected[1]), LOOSE, self.sd)
        return self.channel.fitted(self.X, spread, self.null[0], 30)[1]

    def shown_of(self, parity: Parity) -> Shown:
        """Return `shown` of the columns that a trial makes of this model; trials of other stages make the same."""
        return self.view.once(
            ("shown", self.sensor, self.unasked, self.contact, _sameness(parity)), lambda: self.shown(*parity(self))
        )

    def shown(self, columns: FloatArray, sizes: FloatArray) -> Shown:
        """Return what the parity shows of columns, shape (n, k), of prior sizes (k,).

        A sensor that is elsewhere from the beginning is no fault that begins.
        """
        levels, value, mean, covariance = self._beside(columns, sizes)
        # the same noise must be open to both
        gain = value - max(self.null[1], self._displaced, self.channel.evidence(self.X, self.sd, levels))
        own = tuple(mean[len(mean) - columns.shape[1] :].tolist())
        return Shown(gain, own[-1], float(np.sqrt(covariance[-1, -1])), own)

    def weights_beside(self, columns: FloatArray, sizes: FloatArray) -> FloatArray:
        """Return the weights of the leading profiles that foretell the sensor beside columns in its parity, shape (k,).

        Here the parity is weighed by its noise, of which much is slow where a fault is not quite as the columns say:
        that spoils weights less than least squares.
        """
        centre = self.expected[0]
        return np.asarray(centre + self._beside(columns, sizes)[2][: len(centre)])

    def _beside(self, columns: FloatArray, sizes: FloatArray) -> tuple[Levels, float, FloatArray, FloatArray]:
        """Return the noise of the parity with columns in it, the evidence, coefficients and their covariance."""
        X, sd = np.column_stack([self.X, columns]), np.concatenate([self.sd, sizes])
        levels, value = self.channel.fitted(X, sd, self.null[0], 30)
        return levels, value, *self.channel.estimated(X, sd, levels)


def _sameness(parity: Parity) -> Hashable:
    """Return what is equal for functions that do the same."""
    if not isinstance(parity, partial) or parity.keywords:
        return parity
    same = parity.func, parity.args
    try:
        hash(same)
    except TypeError:  # of an array, say
        return parity
    return same


def _beside_means(values: FloatArray, run: npt.NDArray[np.int64]) -> FloatArray:
    """Return values, shape (n, k), less their mean in each run."""
    count = np.bincount(run)
    means = np.column_stack([np.bincount(run, column) / count for column in values.T])
    return np.asarray(values - means[run])


def _products(P: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ``P'P`` and ``P'y``."""
    return P.T @ P, P.T @ y


def sensor_model(view: View, sensor: str, unasked: tuple[str, ...] = ()) -> SensorModel | None:
    """Return the model of a sensor; None where there are too few others."""
    model = SensorModel(view, sensor, unasked)
    return model if len(model.others) >= FEWEST_OTHERS else None
