"""Environments and arrays for other libraries.

Stable-Baselines3: `sb3.py`; EnvPool's interface: `envpool`; PyTorch and JAX: `arrays.py`.
"""
