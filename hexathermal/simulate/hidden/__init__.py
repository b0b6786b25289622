"""Campaigns that hide something, for testing a diagnosis: benches or machines of many kinds, effects, the answers."""
