"""`TorchEnvs(envs, "cuda")`: what the CPU's tensors show, on a CUDA device, by asynchronous copies."""

from typing import Any

import pytest

import atari

torch = pytest.importorskip("torch", reason="needs PyTorch with CUDA")
if not torch.cuda.is_available():
    pytest.skip("needs a CUDA device that PyTorch can use", allow_module_level=True)

from atari.integrations.torch import TorchEnvs  # noqa: E402


def make(**options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", 8, max_num_frames_per_episode=60, **options)


@pytest.mark.parametrize("options", [{}, {"obs_type": "ram"}, {"obs_type": "dict"}, {"dtype": "float32"}], ids=str)
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_steps_are_those_of_the_cpu(mode: str, options: Any) -> None:
    envs, twin = (TorchEnvs(make(autoreset_mode=mode, **options), device) for device in ("cuda", None))
    kept = [(envs.reset(seed=0), twin.reset(seed=0))]
    for step in range(200):
        action = torch.full((8,), step % 4, device="cuda")
        torch.cuda._sleep(100_000)  # a busy stream: copies must be ordered, not lucky
        kept.append((envs.step(action), twin.step(action.cpu())))
    for results, expected in kept:
        for tensors, wanted in zip(results[:4], expected[:4], strict=False):
            if isinstance(tensors, dict):
                for name, part in tensors.items():
                    if name in ("image", "ram"):
                        assert part.is_cuda
                    assert torch.equal(part.cpu(), wanted[name]) if isinstance(part, torch.Tensor) else True
            else:
                assert tensors.is_cuda
                assert torch.equal(tensors.cpu(), wanted)


def test_the_memory_is_page_locked() -> None:
    envs = TorchEnvs(make(), "cuda")
    envs.reset(seed=0)
    envs.step(torch.zeros(8, dtype=torch.int64, device="cuda"))
    buffers = [buffer for pair in envs._copies._buffers.values() for buffer in pair]
    assert buffers
    assert all(buffer.tensor.is_pinned() for buffer in buffers)
    assert envs._actions.is_pinned()
