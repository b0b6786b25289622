"""Pose and temperatures -> where the platform really stands."""
