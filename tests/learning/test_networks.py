import copy
import pickle
from typing import Any

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from atari.learning import Encoder, TrainingOptions  # noqa: E402
from atari.learning.agents import dqn, ppo, pqn  # noqa: E402
from atari.learning.networks import Normalize  # noqa: E402


def images(count: int, seed: int = 0) -> "torch.Tensor":
    generator = torch.Generator().manual_seed(seed)
    return torch.randint(256, (count, 4, 42, 42), dtype=torch.uint8, generator=generator)


def test_normalize() -> None:
    """It divides by 255; with `running`, pixels have the mean 0 and the variance 1, and constant ones are finite."""
    divides, normalize = (Normalize((4, 42, 42), running=running) for running in (False, True))
    seen = images(1000)
    divides.update(seen)
    assert torch.allclose(divides(seen), seen / 255)
    for part in seen.split(300):
        normalize.update(part)
    values = normalize(seen)
    assert values.mean(0).abs().max() < 1e-4
    assert torch.allclose(values.var(0, correction=0), torch.ones(4, 42, 42), atol=1e-3)
    normalize = Normalize((2,), running=True)
    normalize.update(torch.full((10, 2), 7, dtype=torch.uint8))
    assert normalize(torch.tensor([[7, 255]], dtype=torch.uint8)).tolist() == [[0.0, 5.0]]  # clipped


def test_encoders_of_images() -> None:
    """The network "nature" has the parameters of the paper."""
    small, nature = Encoder((4, 42, 42), "small"), Encoder((4, 84, 84), "nature")
    assert small(images(2)).shape == (2, 256)
    assert nature(torch.zeros(2, 4, 84, 84, dtype=torch.uint8)).shape == (2, 512)
    count = sum(parameter.numel() for parameter in nature.parameters())
    assert count == (8 * 8 * 4 + 1) * 32 + (4 * 4 * 32 + 1) * 64 + (3 * 3 * 64 + 1) * 64 + (3136 + 1) * 512


def test_bits_are_those_of_the_bytes() -> None:
    encoder = Encoder((2, 128), "bits")
    ram = torch.arange(256, dtype=torch.uint8).reshape(1, 2, 128)
    expected = np.unpackbits(ram.numpy()[..., None], axis=-1, bitorder="little")
    assert np.array_equal(encoder.unpack(ram).numpy(), 255 * expected)
    assert encoder(ram).shape == (1, 256)


@pytest.mark.parametrize("layer_norm", [False, True])
def test_bfloat16_is_near_float32(layer_norm: bool) -> None:
    torch.manual_seed(0)
    exact = Encoder((4, 42, 42), "small", layer_norm=layer_norm)
    fast = Encoder((4, 42, 42), "small", layer_norm=layer_norm, bfloat16=True)
    fast.load_state_dict(exact.state_dict())
    seen = images(8)
    assert fast(seen).dtype == torch.float32
    assert (fast(seen) - exact(seen)).abs().max() < 0.05 * exact(seen).abs().max()


@pytest.mark.parametrize("bfloat16", [False, True])
@pytest.mark.parametrize(("kind", "shape"), [("small", (4, 42, 42)), ("mlp", (2, 128)), ("bits", (2, 128))])
def test_prepared_observations_give_the_same_features(kind: str, shape: tuple[int, ...], bfloat16: bool) -> None:
    encoder = Encoder(shape, kind, normalize=True, layer_norm=True, bfloat16=bfloat16)
    seen = torch.randint(256, (5, *shape), dtype=torch.uint8)
    encoder.observe(seen)
    prepared = encoder.prepare(seen)
    assert prepared.is_contiguous()
    assert prepared.dtype == (torch.bfloat16 if bfloat16 else torch.float32)
    assert torch.equal(encoder(prepared), encoder(seen))


def test_a_copy_of_an_encoder_gives_the_same_features() -> None:
    encoder = Encoder((4, 42, 42), "small", normalize=True)
    encoder.observe(images(20))
    for other in (copy.deepcopy(encoder), pickle.loads(pickle.dumps(encoder))):
        assert torch.equal(other(images(3)), encoder(images(3)))


def test_heads() -> None:
    encoder = Encoder((4, 42, 42), "small")
    logits, values = ppo.ActorCritic(encoder, 6)(images(3))
    assert (logits.shape, values.shape) == ((3, 6), (3,))
    network = dqn.QNetwork(encoder, 6, dueling=True)
    features = encoder(images(3))
    assert network.value is not None
    assert torch.allclose(network(images(3)).mean(1), network.value(features)[:, 0], atol=1e-5)
    assert dqn.QNetwork(encoder, 6, dueling=False).value is None
    assert pqn.QNetwork(encoder, 6)(images(3)).shape == (3, 6)


@pytest.mark.parametrize(
    ("capabilities", "device", "expected"),
    [
        ({"avx512_bf16": True, "amx_bf16": False}, "cpu", True),
        ({"avx512_bf16": False, "amx_bf16": True}, "cpu", True),
        ({"avx512_bf16": False, "avx2": True}, "cpu", False),
        *(({}, device, device != "cpu") for device in ("cpu", "cuda", "auto")),
    ],
)
def test_bfloat16_is_chosen_by_the_processor(
    capabilities: dict[str, bool], device: str, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: capabilities, raising=False)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 1)
    for given, computes in (("auto", expected), (True, True), (False, False)):
        assert TrainingOptions.of("pong", bfloat16=given, device=device).computes_bfloat16 == computes


def test_the_device_is_a_gpu_if_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    options = {name: TrainingOptions.of("pong", device=name) for name in ("auto", "cpu", "cuda", "cuda:1")}
    for count, found in ((0, "cpu"), (1, "cuda")):
        monkeypatch.setattr(torch.cuda, "is_available", lambda count=count: count > 0)
        monkeypatch.setattr(torch.cuda, "device_count", lambda count=count: count)
        assert (options["auto"].torch_device, options["cpu"].torch_device) == (found, "cpu")
        for name in ["cuda", "cuda:1"][count:]:
            with pytest.raises(ValueError, match=f"device is '{name}', and PyTorch can use {count} GPUs"):
                _ = options[name].torch_device


class TestNetworksOfOnesOwn:
    """`TrainingOptions.network` as a class or function of the user's."""

    def test_features_of_any_width_are_taken(self) -> None:
        def make(space: Any) -> "torch.nn.Module":
            return torch.nn.Sequential(torch.nn.Flatten(), torch.nn.Linear(int(np.prod(space.shape)), 7))

        encoder = Encoder((4, 42, 42), make)
        assert encoder.width == 7
        assert torch.allclose(encoder(images(2)), encoder.layers(images(2) / 255))
        assert pqn.QNetwork(encoder, 3)(images(2)).shape == (2, 3)

    @pytest.mark.parametrize(
        ("made", "kind", "text"),
        [
            (3, TypeError, r"must make a torch.nn.Module from the observation space, got 3"),
            (torch.nn.Linear(5, 3), ValueError, r"fails with observations of shape \(2, 4, 42, 42\): mat1"),
            (torch.nn.Identity(), ValueError, r"floats \(n, width\).* returned torch.float32 \(2, 4, 42, 42\)"),
            (torch.nn.Flatten(0), ValueError, r"it returned torch.float32 \(14112,\)"),
            (torch.nn.LSTM(42, 3), ValueError, r"fails with observations"),
        ],
    )
    def test_others_are_refused(self, made: Any, kind: type[Exception], text: str) -> None:
        with pytest.raises(kind, match=text):
            Encoder((4, 42, 42), lambda space: made)
