"""Programs that use PyTorch run to their end, and nothing of this package is left then.

PyTorch holds the module `typing` to the end, and with it whatever `typing` has registered.
"""

from pathlib import Path

import pytest
from own_process import REPORTING, printed_at_end

pytest.importorskip("torch")

PROGRAM = """
import sys, torch, atari, atari.lab, atari.recording
from pathlib import Path
from atari.learning import RunFolder
from atari.learning.agents.ppo import PPOOptions
from atari.learning.training import Training
core = atari.cores.NativeCore("pong")
network = torch.nn.Linear(128, 6)
envs = atari.AtariVectorEnv("pong", 2)
run = RunFolder.begin({folder!r} + "/run", "mine", envs.task, {{}})
run.log({{"step": 100, "score": -21.0}})  # with TensorBoard
run.checkpoint(100, {{"network": network.state_dict()}}, network.state_dict())
options = PPOOptions.of("Pong-ram-v4", num_envs=2, total_steps=64, horizon=16, minibatch=32)
training = Training.begin("ppo", options, Path({folder!r}, "ppo"))
training.run()
training.close()
"""


def test_nothing_is_left(tmp_path: Path) -> None:
    """A program ends that has a core, a run folder and a training, beside recorders and the lab."""
    assert "nanobind" not in printed_at_end(REPORTING + PROGRAM.format(folder=str(tmp_path)))


def test_nothing_is_printed_of_tensors() -> None:
    """PyTorch does not release the memory of tensors that exist when the interpreter ends: what is left is no fault here."""
    program = """
        import torch, atari
        from atari.integrations.torch import TorchEnvs
        envs = TorchEnvs(atari.AtariVectorEnv("pong", 2))
        observations, info = envs.reset(seed=0)
    """
    assert "nanobind" not in printed_at_end(program)
