"""Speed, error and memory of hexathermal against a C++ yardstick, MuJoCo, Pinocchio and NumPy, in one run.

Run as ``python -m benchmarks`` from the root of the repository.
"""
