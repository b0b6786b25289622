"""A second path to the platform's error: NumPy, Newton on the lengths, the law written from its definition."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial.transform import Rotation

import hexathermal as ht


def thermal_machine(name: str = "reference") -> ht.Hexapod:
    """Return a bundled machine with two sensors a leg, a thermometer on the platform only, and six different laws."""
    legs = [ht.LegLaw(("a", "b"), [1.2e-6 + 1e-7 * i, 0.8e-6], [0.5e-6, 0.6e-6 - 5e-8 * i]) for i in range(6)]
    model = ht.ThermalModel(
        legs, ht.PlateLaw(11.5e-6, "T"), ht.PlateLaw(9e-6), reference_temperature_degC=20.0, valid_degC=(0.0, 50.0)
    )
    return dataclasses.replace(ht.load_hexapod(name), thermal=model)


def warm_points(v, alpha, dT, g, rest):
    """Return joints (..., 6, 3) of a plate after free expansion with a linear temperature field about `rest`."""
    r = v - rest
    along = (g * r).sum(axis=-1, keepdims=True)
    return rest + r + alpha * (dT * r + along * r - 0.5 * (r * r).sum(axis=-1, keepdims=True) * g)


def solve(p, b, L, pose):
    """Return poses (N: R (3, 3), t (3,)) with |t + R p - b| = L by Newton from `pose`; p, b (N, 6, 3), L (N, 6)."""
    n = len(L)
    R, t = np.repeat(pose[None, :3, :3], n, axis=0), np.repeat(pose[None, :3, 3], n, axis=0)
    for _ in range(8):
        s = np.einsum("nij,nkj->nki", R, p)
        d = s + t[:, None] - b
        length = np.linalg.norm(d, axis=-1)
        u = d / length[..., None]
        J = np.concatenate([u, np.cross(s, u)], axis=-1)
        x = np.linalg.solve(J, (L - length)[..., None])[..., 0]
        t = t + x[:, :3]
        R = Rotation.from_rotvec(x[:, 3:]).as_matrix() @ R
    assert abs(x).max() < 1e-13
    return R, t


def errors(R, t, pose, arm):
    """Return errors (N, 6) of a point in base axes."""
    shift = t + R @ arm - (pose[:3, 3] + pose[:3, :3] @ arm)
    turn = Rotation.from_matrix(R @ pose[:3, :3].T).as_rotvec()
    return np.concatenate([shift, turn], axis=1)


class Oracle:
    """A machine at a pose, told lengths `told`, whose numbers may be off by arrays (N, ...)."""

    def __init__(self, hexapod, pose, temps, told, arm=(0.0, 0.0, 0.0), plate_dT=(0.0, 0.0), air=20.0):
        self.hexapod, self.pose, self.arm = hexapod, pose, np.asarray(arm)
        self.temps, self.told, self.plate_dT, self.air = np.asarray(temps, float), told, plate_dT, air

    def __call__(self, n, off):
        """Return errors (n, 6) for a dict of quantities that are off, each (n, k)."""
        h, model = self.hexapod, self.hexapod.thermal
        names = model.sensor_names
        sensors = len(names)
        z = {key: np.asarray(value, float) for key, value in off.items()}

        def of(key, k):
            return z.get(key, np.zeros((n, k)))

        reference = of("reference temperature", 1)
        dT = (self.temps - 20.0) * (1.0 + of("gain", sensors)) + of("contact", sensors) * (self.temps - self.air)
        dT = dT + of("temperature", sensors) - reference
        counts = [len(law.sensors) for law in model.legs]
        q0 = h.retracted_length
        L, first, column = np.empty((n, 6)), 0, 0
        coefficients = of("coefficients", 2 * sum(counts))
        for i, law in enumerate(model.legs):
            s = counts[i]
            A, B = law.A + coefficients[:, column : column + s], law.B + coefficients[:, column + s : column + 2 * s]
            column += 2 * s
            own = dT[:, first : first + s]
            first += s
            growth = of("growth", 6)[:, i] * own.mean(axis=1)
            q = self.told[i] - q0[i]
            drift = ((A * own).sum(axis=1) + growth) * q0[i] + ((B * own).sum(axis=1) + growth) * q
            L[:, i] = self.told[i] + drift + of("length", 6)[:, i] + of("scale", 6)[:, i] * q
        joints = []
        for part, (plate, given) in enumerate(((model.platform, h.platform_joints), (model.base, h.base_joints))):
            warm = self.plate_dT[part] + of("plate temperature", 2)[:, part : part + 1] - reference
            rest = np.zeros(3)
            if plate is not None and plate.sensor is not None:
                column = names.index(("platform_", "base_")[part] + plate.sensor)
                warm = dT[:, column : column + 1] + of("plate temperature", 2)[:, part : part + 1]
            elif part == 1:
                rest = given.mean(axis=0)
            alpha = (0.0 if plate is None else plate.expansion) + of("plate expansion", 2)[:, part : part + 1]
            g = of("plate gradient", 6)[:, 3 * part : 3 * part + 3]
            moved = warm_points(given[None], alpha[:, None], warm[:, None], g[:, None], rest)
            joints.append(moved + of(("platform joints", "base joints")[part], 18).reshape(n, 6, 3))
        R, t = solve(joints[0], joints[1], L, self.pose)
        return errors(R, t, self.pose, self.arm) + of("pose", 6)
