"""Environments and arrays for other libraries: Stable-Baselines3 (`sb3.py`), PyTorch and JAX (`arrays.py`)."""
