"""The virtual bench: a leg that warms up, its thermometers, its interferometers, its room.

=====================  =============================================================================================
`parts`, `leg`         the leg: finite volumes along body and rod; `VirtualLeg` stands alone
`mechanics`            scatter of landings, settling, the scale's short-period error
`room`, `scenario`     the air of the room; commands and how the rod follows them; `tables`: commands from a file
`thermocouples`        what is read of the leg's surface
`interferometers`      what three beams show through the air, and the weather station
`bench`                all of it: `Bench`, `simulate_bench`
`campaign_folder`      a campaign folder that looks measured; `truth`: what it was made of
=====================  =============================================================================================
"""
