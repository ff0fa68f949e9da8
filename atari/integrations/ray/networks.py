"""RLlib's own networks for observations as bytes: their first layer divides by 255.

RLlib's default networks take float32. With these networks, episodes, the object store and replay buffers hold
bytes, which are a quarter of the size, and the network converts them on its own device.
"""

from typing import Any

import torch
from ray.rllib.algorithms.dqn.dqn_catalog import DQNCatalog
from ray.rllib.algorithms.ppo.ppo_catalog import PPOCatalog
from ray.rllib.core.models.configs import CNNEncoderConfig, MLPEncoderConfig


class Scale(torch.nn.Module):
    """Scales tensors with values 0 to 255, of any type, to float32 values 0 to 1."""

    def forward(self, values: torch.Tensor) -> torch.Tensor:
        """The scaled values, in the same shape."""
        return values.float() / 255


class _ScalingEncoder:
    def build(self, framework: str = "torch") -> Any:
        """RLlib's encoder, after `Scale`."""
        encoder = super().build(framework)  # type: ignore[misc]
        encoder.net = torch.nn.Sequential(Scale(), encoder.net)
        return encoder


class ScalingCNN(_ScalingEncoder, CNNEncoderConfig):
    """RLlib's convolutions, for images as bytes."""


class ScalingMLP(_ScalingEncoder, MLPEncoderConfig):
    """RLlib's fully connected layers, for rows of bytes."""


class _ScalingCatalog:
    @classmethod
    def _get_encoder_config(cls, observation_space: Any, model_config_dict: Any, action_space: Any = None) -> Any:
        config = super()._get_encoder_config(observation_space, model_config_dict, action_space)  # type: ignore[misc]
        kinds = {CNNEncoderConfig: ScalingCNN, MLPEncoderConfig: ScalingMLP}
        # An LSTM's config is neither of these; another call of this method makes the network before the LSTM.
        return kinds[type(config)](**vars(config)) if type(config) in kinds else config


class ScalingPPOCatalog(_ScalingCatalog, PPOCatalog):
    """Networks for PPO, IMPALA and APPO."""


class ScalingDQNCatalog(_ScalingCatalog, DQNCatalog):
    """Networks for DQN."""
