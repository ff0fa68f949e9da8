"""The methods of a policy that show more than its actions, and the formats of policies that have them."""

from collections.abc import Callable, Mapping
from types import MethodType
from typing import Any

from atari.base.frozen import FrozenDict

METHODS = ("scores", "values", "probabilities", "features", "network")

FORMATS: Mapping[str, tuple[str, ...]] = FrozenDict(
    {
        "run folders of PPO": METHODS,
        "run folders of PQN and DQN": ("scores", "values", "features", "network"),
        "models of Stable-Baselines3: PPO, A2C": METHODS,
        "models of Stable-Baselines3: DQN, QR-DQN": ("scores", "values", "features", "network"),
        "networks of PyTorch": ("scores", "features", "network"),
        "TorchScript files": ("scores", "network"),
        "ONNX files": ("scores",),
        "random and noop": (),
    }
)
"""The methods of each format that `load_policy` loads."""

SAMPLED = ("run folders of PQN and DQN", "networks of PyTorch", "TorchScript files", "ONNX files")
"""The formats that have `probabilities` if they are loaded with sample=True, which says that scores are logits."""


def absent(policy: str, method: str) -> AttributeError:
    """The error of a policy without one of `METHODS`; it names the formats that have the method."""
    formats = [name for name, methods in FORMATS.items() if method in methods]
    if method == "probabilities":
        formats += [f"{name} loaded with sample=True" for name in SAMPLED]
    return AttributeError(
        f"policy {policy} has no {method}; these have: {'; '.join(formats)}; objects with an attribute {method}"
    )


class OptionalMethod:
    """Decorates a method that exists only for policies with its name in their `_methods`.

    For others the attribute is missing: `hasattr` is false, and the error is that of `absent`.
    """

    def __init__(self, method: Callable[..., Any]) -> None:
        self._method = method

    def __get__(self, policy: Any, owner: type | None = None) -> Any:
        if policy is None:
            return self._method
        if self._method.__name__ not in policy._methods:
            raise absent(policy.name or type(policy).__name__, self._method.__name__)
        return MethodType(self._method, policy)
