"""Acceptance of a machine: pose accuracy, environmental variation, and the decision whether limits are met."""

from hexathermal.predict.acceptance.conformance import conformance_probability
from hexathermal.predict.acceptance.decision_rules import FAIL, NOT_DECIDED, PASS, RULES, Decision, decide
from hexathermal.predict.acceptance.environmental_variation import (
    EnvironmentalVariation,
    WarmUpDistortion,
    environmental_variation,
    warm_up_distortion,
)
from hexathermal.predict.acceptance.evaluation import Acceptance, Result, accept
from hexathermal.predict.acceptance.measured_poses import MeasuredPoses, read_measured_poses
from hexathermal.predict.acceptance.pose_accuracy import PoseAccuracy, PoseDrift, pose_accuracy, pose_drift
from hexathermal.predict.acceptance.specification import Limit, Specification, read_specification

__all__ = [
    "FAIL",
    "NOT_DECIDED",
    "PASS",
    "RULES",
    "Acceptance",
    "Decision",
    "EnvironmentalVariation",
    "Limit",
    "MeasuredPoses",
    "PoseAccuracy",
    "PoseDrift",
    "Result",
    "Specification",
    "WarmUpDistortion",
    "accept",
    "conformance_probability",
    "decide",
    "environmental_variation",
    "pose_accuracy",
    "pose_drift",
    "read_measured_poses",
    "read_specification",
    "warm_up_distortion",
]
