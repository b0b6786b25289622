"""The virtual bench driven by a measured campaign: simulated against measured, and the physics in which they part.

The one storey that sees both `hexathermal.learn` (what was measured) and `hexathermal.simulate` (the bench).

==================  ================================================================================================
`comparison`        `compare_campaign`: all of it, in one call
`placing`           the leg that stands for the campaign's, its thermocouples on it
`measured`          motion and room of all rows; settled rows in windows
`bench_runs`        the same runs on the bench, for several variants of its numbers
`parameters`        which numbers: names, physics, experiments
`noise`             white and slow noise of each channel
`evidence`          whitened sums, estimates, evidence
`steps`             forward steps: what differs, on runs left out
`scores`            before and after, channel by channel
==================  ================================================================================================
"""
