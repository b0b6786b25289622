"""The Pinocchio machine against its limits: joint angles, margins, distances between legs; solids to draw.

Distances are coal's, between capsules of the leg diameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.pinocchio_loads import LegJoints, Shapes
from hexathermal.poses import FloatArray

COLOURS = {"base": (0.35, 0.37, 0.40), "platform": (0.20, 0.45, 0.70), "joint": (0.75, 0.55, 0.20)}
COLOURS |= {"body": (0.55, 0.57, 0.60), "rod": (0.85, 0.86, 0.88)}
"""Red, green, blue of the drawing, by the last word of a solid's name."""


@dataclass(frozen=True, eq=False)
class JointAngles:
    """Where all joints stand; every angle and `travel` is 0 at home.

    Attributes
    ----------
    universal : array, shape (6, 2) [rad]
        Turn about the first axis (fixed to the base, across leg and base z), then about the second.
    travel : array, shape (6,) [m]
        Of the prismatic joint, counted from home: ``travel = L - L_home``; the stroke is ``q = L - q0``.
    spherical : array, shape (6, 3) [rad]
        Rotation vector of the platform against the leg, in the leg's axes (z along the leg).
    base_cone, platform_cone : array, shape (6,) [rad]
        Angle between the leg and its direction at home, seen from the base and from the platform.
    """

    universal: FloatArray
    travel: FloatArray
    spherical: FloatArray
    base_cone: FloatArray
    platform_cone: FloatArray


@dataclass(frozen=True, eq=False)
class Clearance:
    """How far the legs stand apart at a pose.

    Attributes
    ----------
    between : array, shape (6, 6) [m]
        Smallest distance of each two legs, negative where they overlap; infinity on the diagonal.
    smallest : float [m]
        Smallest of all.
    legs : (int, int)
        The two legs that are nearest, 1 to 6.
    parts : (str, str)
        ``"body"`` or ``"rod"`` of each.
    points : array, shape (2, 3) [m]
        Nearest point of each, base frame.
    """

    between: FloatArray
    smallest: float
    legs: tuple[int, int]
    parts: tuple[str, str]
    points: FloatArray

    @property
    def collision(self) -> bool:
        """Whether any two legs touch: ``smallest <= 0``."""
        return self.smallest <= 0.0


@dataclass(frozen=True, eq=False)
class Margins:
    """What is left to each limit: negative is beyond it, infinity where the machine states no limit.

    Attributes
    ----------
    stroke : array, shape (6, 2) [m]
        ``[L - shortest, longest - L]``.
    base_cone, platform_cone : array, shape (6,) [rad]
        ``cone - angle``.
    rod_overlap : array, shape (6,) [m]
        Length of rod inside the body.  Its sections are derived, not stated: `allowed` does not ask it.
    clearance : Clearance
        Distances between the legs.
    """

    stroke: FloatArray
    base_cone: FloatArray
    platform_cone: FloatArray
    rod_overlap: FloatArray
    clearance: Clearance

    @property
    def collision(self) -> bool:
        """Whether any two legs touch."""
        return self.clearance.collision

    @property
    def allowed(self) -> bool:
        """Whether stroke and cone margins are all >= 0 and no legs touch."""
        cones = min(self.base_cone.min(), self.platform_cone.min())
        return bool(min(self.stroke.min(), cones) >= 0.0) and not self.collision


class Solid(NamedTuple):
    """A solid to draw: name, `trimesh.Trimesh` in its own frame [m], and that frame in the base (4, 4)."""

    name: str
    mesh: Any
    pose: FloatArray


def joint_angles(legs: FloatArray) -> JointAngles:
    """Return the joint angles of six rows ``[2 universal, prismatic, quaternion xyzw]``."""
    (s0, s1), (c0, c1) = np.sin(legs[:, :2]).T, np.cos(legs[:, :2]).T
    x, y, z, w = legs[:, 3:].T
    return JointAngles(
        universal=legs[:, :2],
        travel=legs[:, 2],
        spherical=np.array([pin.log3(pin.Quaternion(ball).matrix()) for ball in legs[:, 3:]]),
        base_cone=np.arctan2(np.hypot(s1, s0 * c1), c0 * c1),
        platform_cone=2.0 * np.arctan2(np.hypot(x, y), np.hypot(z, w)),
    )


def margins(
    hexapod: Hexapod, shapes: Shapes, lengths: FloatArray, angles: JointAngles, legs_apart: Clearance
) -> Margins:
    """Return what is left to each limit of the machine at these lengths and joint angles."""
    shortest, longest = hexapod.length_limits
    stroke = np.stack([lengths - shortest, longest - lengths], axis=1)
    cones = (hexapod.base_cone, hexapod.platform_cone)
    at_base, at_platform = (np.full(6, np.inf) if cone is None else cone for cone in cones)
    return Margins(
        stroke=np.full((6, 2), np.inf) if hexapod.stroke is None else stroke,
        base_cone=at_base - angles.base_cone,
        platform_cone=at_platform - angles.platform_cone,
        rod_overlap=shapes.body_lengths + shapes.rod_lengths - lengths,
        clearance=legs_apart,
    )


def capsule_ends(shapes: Shapes, leg: int, home_length: float) -> tuple[FloatArray, FloatArray]:
    """Return where the axes of a leg's body and rod capsule begin and end at home, from the base joint [m].

    At its joint each begins one own diameter off the centre (a fork or a ball stands there, not a tube), but
    not more than a quarter of its length.  The body's axis ends where the body ends, so its cap reaches one
    radius further; the rod's covers what stands out of the body at full stretch.
    """
    body, rod = float(shapes.body_lengths[leg]), float(shapes.rod_shown[leg])
    body_gap = min(shapes.bodies.leg_body_diameter, 0.25 * body)
    rod_gap = min(shapes.bodies.leg_rod_diameter, 0.25 * rod)
    return np.array([body_gap, body]), np.array([home_length - rod, home_length - rod_gap])


def _along(low: float, high: float) -> pin.SE3:
    """Return the frame in the middle of a stretch of a leg's z."""
    return pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.5 * (low + high)]))


def hinged_pairs(hexapod: Hexapod, shapes: Shapes) -> tuple[tuple[str, str], ...]:
    """Return the pairs of capsules that are left out, because they hang on one hinge.

    Two bodies whose base joints are nearer than a body diameter overlap at that joint at every pose (a 3-3
    machine, whose legs share joints); so do two rods whose platform joints are nearer than a rod diameter.
    Body against rod of the same two legs stays, and so does the like pair at the legs' other end.
    """
    sides = (
        ("body", hexapod.base_joints, shapes.bodies.leg_body_diameter),
        ("rod", hexapod.platform_joints, shapes.bodies.leg_rod_diameter),
    )
    return tuple(
        (f"leg{i + 1}_{part}", f"leg{j + 1}_{part}")
        for part, joints, diameter in sides
        for i in range(6)
        for j in range(i + 1, 6)
        if np.linalg.norm(joints[i] - joints[j]) < diameter
    )


def collision_model(
    hexapod: Hexapod, shapes: Shapes, joints: tuple[LegJoints, ...], lengths: FloatArray
) -> pin.GeometryModel:
    """Return two capsules a leg and all pairs of different legs, less `hinged_pairs`."""
    geometry = pin.GeometryModel()
    for leg, joint in enumerate(joints):
        body, rod = capsule_ends(shapes, leg, float(lengths[leg]))
        for part, parent, (low, high), diameter in (
            ("body", joint.universal, body, shapes.bodies.leg_body_diameter),
            ("rod", joint.prismatic, rod, shapes.bodies.leg_rod_diameter),
        ):
            capsule = coal.Capsule(0.5 * diameter, float(high - low))
            solid = pin.GeometryObject(f"leg{leg + 1}_{part}", parent, _along(low, high), capsule)
            geometry.addGeometryObject(solid)
    left_out = set(hinged_pairs(hexapod, shapes))
    names = [item.name for item in geometry.geometryObjects]
    for a in range(12):
        for b in range(2 * (a // 2) + 2, 12):
            if (names[a], names[b]) not in left_out:
                geometry.addCollisionPair(pin.CollisionPair(a, b))
    return geometry


def clearance(geometry: pin.GeometryModel, placed: pin.GeometryData) -> Clearance:
    """Read the distances that Pinocchio has computed."""
    between = np.full((6, 6), np.inf)
    found = [result.min_distance for result in placed.distanceResults]
    for pair, distance in zip(geometry.collisionPairs, found, strict=True):
        i, j = pair.first // 2, pair.second // 2
        between[i, j] = between[j, i] = min(between[i, j], distance)
    nearest, kinds = int(np.argmin(found)), ("body", "rod")
    pair, result = geometry.collisionPairs[nearest], placed.distanceResults[nearest]
    return Clearance(
        between=between,
        smallest=float(result.min_distance),
        legs=(pair.first // 2 + 1, pair.second // 2 + 1),
        parts=(kinds[pair.first % 2], kinds[pair.second % 2]),
        points=np.array([result.getNearestPoint1(), result.getNearestPoint2()]),
    )


def visual_model(
    hexapod: Hexapod, shapes: Shapes, joints: tuple[LegJoints, ...], lengths: FloatArray, platform: int
) -> pin.GeometryModel:
    """Return plates, joints, bodies and rods as coal cylinders and spheres, for `pinocchio.visualize`."""
    geometry = pin.GeometryModel()

    def add(name: str, parent: int, placement: pin.SE3, shape: Any) -> None:
        item = pin.GeometryObject(name, parent, placement, shape)
        item.meshColor = np.array([*COLOURS[name.split("_")[-1]], 1.0])
        geometry.addGeometryObject(item)

    for name, parent, plate in (("base", 0, shapes.base), ("platform", platform, shapes.platform)):
        add(name, parent, plate.placement, coal.Cylinder(plate.radius, plate.thickness))
    outer, inner = 0.5 * shapes.bodies.leg_body_diameter, 0.5 * shapes.bodies.leg_rod_diameter
    for leg, joint in enumerate(joints):
        label, body, rod = f"leg{leg + 1}", float(shapes.body_lengths[leg]), float(shapes.rod_lengths[leg])
        at_base = pin.SE3(np.eye(3), hexapod.base_joints[leg])
        at_platform = pin.SE3(np.eye(3), hexapod.platform_joints[leg])
        add(f"{label}_base_joint", 0, at_base, coal.Sphere(1.1 * outer))
        add(f"{label}_platform_joint", platform, at_platform, coal.Sphere(1.3 * inner))
        add(f"{label}_body", joint.universal, _along(0.0, body), coal.Cylinder(outer, body))
        end = float(lengths[leg])
        add(f"{label}_rod", joint.prismatic, _along(end - rod, end), coal.Cylinder(inner, rod))
    return geometry


def solids(geometry: pin.GeometryModel, placed: pin.GeometryData) -> list[Solid]:
    """Return the solids of a placed visual model as trimesh meshes."""
    import trimesh  # slow to load, and only drawings need it

    drawn = []
    for item, placement in zip(geometry.geometryObjects, placed.oMg, strict=True):
        shape = item.geometry
        if isinstance(shape, coal.Sphere):
            mesh = trimesh.creation.icosphere(subdivisions=2, radius=shape.radius)
        else:
            mesh = trimesh.creation.cylinder(radius=shape.radius, height=2.0 * shape.halfLength, sections=32)
        mesh.visual.face_colors = np.round(255.0 * item.meshColor).astype(np.uint8)
        drawn.append(Solid(item.name, mesh, np.array(placement.homogeneous)))
    return drawn
