"""Hexapod campaigns that hide something: machines and halls drawn, effects in full geometry, and the answers.

`rotation`, `posture`   quaternions; where a platform stands on six given lengths, solved for position and quaternion
`truth`, `physics`      what truly happens, and where that puts the platform
`geometry`, `motion`    machines, bundled or drawn, with their laws; poses and times of a campaign
`halls`                 how warm everything gets, one module each; `campaign`: one with nothing hidden in it
`effects`               what can be hidden, one module each; `effect`, `plates`: what several of them use
`strength`              how strong an effect is against the noise, and what knowing it would gain
`drawing`, `writing`    a campaign and its answer; both as files

Nothing here stands on `hexathermal.kinematics` or `hexathermal.predict`: a diagnosis that rests on those is tried on a
truth which another way of reckoning made.
"""
