"""Programs that use PyTorch run to their end, and nothing of this package is left then.

PyTorch holds the module `typing` to the end, and with it whatever `typing` has registered.
"""

from pathlib import Path

import pytest
from programs import REPORTING, printed_at_end

pytest.importorskip("torch")

ENDS = {
    "recorders and the lab beside PyTorch": """
        import torch, atari, atari.lab, atari.recording
        core = atari.cores.NativeCore("pong")
    """,
    "a run folder with TensorBoard": """
        import atari, torch
        from atari.learning import RunFolder
        network = torch.nn.Linear(128, 6)
        envs = atari.AtariVectorEnv("pong", 2)
        run = RunFolder.begin({folder!r} + "/run", "mine", envs.task, {{}})
        run.log({{"step": 100, "score": -21.0}})
        run.checkpoint(100, {{"network": network.state_dict()}}, network.state_dict())
    """,
    "a training": """
        from atari.learning.agents.ppo import PPOOptions
        from atari.learning.training import Training
        options = PPOOptions.of("Pong-ram-v4", num_envs=2, total_steps=64, horizon=16, minibatch=32)
        training = Training.begin("ppo", options, {folder!r} + "/ppo")
        training.run()
        training.close()
    """,
}


@pytest.mark.parametrize("name", ENDS)
def test_nothing_is_left(name: str, tmp_path: Path) -> None:
    lines = (line.removeprefix("        ") for line in ENDS[name].format(folder=str(tmp_path)).splitlines())
    assert "nanobind" not in printed_at_end(REPORTING + "\n".join(lines) + "\n")


def test_nothing_is_printed_of_tensors() -> None:
    """PyTorch does not release the memory of tensors that exist when the interpreter ends: what is left is no fault here."""
    program = """
        import torch, atari
        from atari.integrations.torch import TorchEnvs
        envs = TorchEnvs(atari.AtariVectorEnv("pong", 2))
        observations, info = envs.reset(seed=0)
    """
    assert "nanobind" not in printed_at_end(program)
