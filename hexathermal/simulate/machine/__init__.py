"""The virtual hexapod: six virtual legs between two plates, in a room, looked at by a 6-D positioning system.

===================  ===============================================================================================
`parts`              plates, positioning system, what users do with the machine
`heat`               the flow of heat through legs and plates; the legs are those of the virtual bench
`motion`             from pose to pose, with errands and rests
`machine`            all of it: `VirtualMachine`; `building`: how one is made of a `Hexapod`
`runs`               `simulate_machine`: what happens in a run, and what is written of it
`campaign_folder`    a campaign folder of kind ``"hexapod"``; `truth`: what it was made of
===================  ===============================================================================================
"""
