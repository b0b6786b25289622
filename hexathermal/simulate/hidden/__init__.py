"""Campaigns that hide something, for testing a diagnosis: benches of different physics, effects, and the answers."""
