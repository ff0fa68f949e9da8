"""Environments and arrays for other libraries.

Stable-Baselines3: `sb3.py`; EnvPool's interface: `envpool`; Ray: `ray`; JAX: `jax`; PyTorch: `torch.py`;
TorchRL: `torchrl.py`; arrays for PyTorch and JAX: `arrays.py`.
"""
