"""Pose <-> leg lengths, compiled."""
