"""`check_core`: cores with one fault each, and the sentence that each gets. `tests/cores/test_contract.py` has ours."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from atari.cores import NativeCore
from atari.testing import ContractError, check_core


class ForgetsGenerator(NativeCore):
    def restore(self, data: bytes) -> None:
        other = NativeCore(self.game, **self.__dict__["given"])
        other.restore(data)
        self.restore_state(other.clone_state())

    def __init__(self, game: str, **options: Any) -> None:
        super().__init__(game, **options)
        self.given = {**options, "seed": 0}


class KeepsArrays(NativeCore):
    def ram(self, out: Any = None) -> Any:
        if out is None:
            out = self.__dict__.setdefault("_own", np.empty(128, np.uint8))
            if getattr(self, "_read", None) == self.frame_number:
                return out
            self._read = self.frame_number
        return super().ram(out)


def faulty(**methods: Callable[..., Any]) -> type[NativeCore]:
    """The class of cores with other methods: functions of the core, of the method of `NativeCore`, and of the arguments."""

    def method(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        own = getattr(NativeCore, name)
        return lambda self, *arguments, **options: call(self, partial(own, self), *arguments, **options)

    return type("Faulty", (NativeCore,), {name: method(name, call) for name, call in methods.items()})


IgnoresOut = faulty(screen=lambda core, own, out=None: own())
SignedSound = faulty(audio=lambda core, own, out=None: own(out).astype(np.int16))
SeedsLater = faulty(seed=lambda core, own, seed: own((seed + 1) % 2**32))
WrapsAddresses = faulty(
    set_ram=lambda core, own, index, value: own(index % 128 if isinstance(index, int) else index, value)
)
WrapsActions = faulty(
    act=lambda core, own, action, strength=1.0: own(action % 18 if type(action) is int else action, strength)
)
PaysAfterTheEnd = faulty(act=lambda core, own, *arguments: 1 if core.truncated else own(*arguments))
DoublesRewards = faulty(act=lambda core, own, *arguments: own(*arguments) + int(core.episode_frame_number == 40))
LosesSound = faulty(with_sound=lambda core, own: core if core.sound else NativeCore(core.game, sound=True))
ClonesWithoutGenerator = faulty(clone_state=lambda core, own, include_rng=False: own())
StaysOpen = faulty(close=lambda core, own: None)
RaisesAtClose = faulty(close=lambda core, own: (core.ram(), own()))
NoFrameSkip = faulty(__init__=lambda core, own, game, frame_skip=1, **options: own(game, **options))
NoSeed = faulty(__init__=lambda core, own, game, seed=0, **options: own(game, **options))
WritesTwice = faulty(set_ram=lambda core, own, index, value: (own(index, value), own((index + 1) % 128, 1)))
PlaysToRedraw = faulty(redraw=lambda core, own, out=None: (core.act(0), own(out))[1])


class WidensOut(NativeCore):
    def audio(self, out: Any = None) -> Any:
        if out is None:
            return super().audio()
        np.asarray(out).reshape(-1)[:512] = super().audio()
        return out


class Noisy(NativeCore):
    def screen_grayscale(self, out: Any = None) -> Any:
        gray = super().screen_grayscale(out)
        gray[:, 0] ^= 1
        return gray


class OwnSeed(NativeCore):
    made = 0

    def __init__(self, game: str, *, seed: int = 0, **options: Any) -> None:
        OwnSeed.made += 1
        super().__init__(game, seed=OwnSeed.made, **options)


class PlaysBeforeItChecks(NativeCore):
    def act(self, action: int, strength: float = 1.0) -> int:
        try:
            return super().act(action, strength)
        except (TypeError, ValueError):
            super().act(0)
            raise


class FixedMode(NativeCore):
    def set_mode(self, mode: int) -> None:
        before = self.mode
        super().set_mode(mode)
        super().set_mode(before)


class LosesMode(NativeCore):
    def with_sound(self) -> NativeCore:
        core = super().with_sound()
        core.set_mode(self.game.default_mode)
        return core


class TakesAnyChance(NativeCore):
    def __init__(self, game: str, *, repeat_action_probability: Any = 0.25, **options: Any) -> None:
        chance = max(repeat_action_probability, 0) if isinstance(repeat_action_probability, float) else 0.25
        super().__init__(game, repeat_action_probability=chance, **options)


class TakesLongSnapshots(NativeCore):
    def restore(self, data: bytes) -> None:
        super().restore(data[:-1] if isinstance(data, bytes) and data.endswith(b"\0") and self._longer(data) else data)

    def _longer(self, data: bytes) -> bool:
        try:
            type(self).__mro__[1](self.game).restore(data[:-1])
        except ValueError:
            return False
        return True


FAULTS: dict[type[NativeCore], str] = {
    ForgetsGenerator: "after restore() in the same core, snapshot() must return what was restored",
    KeepsArrays: "an array of ram() must belong to the caller; ram is ",
    IgnoresOut: "screen(out) must return out",
    WidensOut: "audio(out) with an out that is of another shape must raise ValueError, but raised nothing",
    SignedSound: "audio() must return a contiguous uint8 array (512,), got int16 (512,)",
    Noisy: "each palette index of screen() must have one color and one luminance",
    NoFrameSkip: "1 acts of frame_skip=3 must count 3 frames, got [1, 1]",
    NoSeed: "six seeds gave the same RAM",
    OwnSeed: "equal seeds must give equal games; play[",
    SeedsLater: "seed(0) must start over as a core made with it",
    WrapsAddresses: "set_ram(-1, 0) must raise TypeError or ValueError, but raised nothing",
    WritesTwice: "set_ram(127, 255) must write this byte alone; ram() is 1 at (0,)",
    WrapsActions: "act(-1) must raise TypeError or ValueError, but raised nothing",
    PlaysBeforeItChecks: "act(-1) must change nothing; the core",
    PaysAfterTheEnd: "act() after the end must return the reward 0, got 1",
    DoublesRewards: "must be as on 'native'; the core['reward'] is 1 instead of 0",
    PlaysToRedraw: "redraw() must change nothing; the core",
    LosesSound: "with_sound() must keep the state",
    LosesMode: "with_sound() must keep the mode 1, got 0",
    FixedMode: "mode of a core made with mode=1 must be 1, got 0",
    TakesAnyChance: "make(repeat_action_probability=-0.1) must raise TypeError or ValueError",
    TakesLongSnapshots: "restore() of a snapshot with a byte more must raise ValueError",
    ClonesWithoutGenerator: "a cloned state with its generators must continue exactly",
    StaysOpen: "seed() after close() must raise RuntimeError, but raised nothing",
    RaisesAtClose: "close() after close() raised RuntimeError: this core is closed",
}


@pytest.mark.parametrize(
    "core_type", FAULTS, ids=lambda each: next(name for name, kind in globals().items() if kind is each)
)
def test_a_core_with_a_fault_gets_its_sentence(core_type: Callable[..., Any]) -> None:
    with pytest.raises(ContractError) as caught:
        check_core(partial(core_type, "pong"), reference=partial(NativeCore, "pong"), steps=40)
    assert FAULTS[core_type] in str(caught.value)  # type: ignore[index]


def test_a_core_without_an_option_gets_its_sentence() -> None:
    with pytest.raises(ContractError, match=r"^make\(sound=True\) raised TypeError: .* unexpected keyword .*'sound'"):
        check_core(lambda seed=0: NativeCore("pong", seed=seed))


@pytest.mark.parametrize("make", [NativeCore("pong"), "pong"])
def test_only_a_function_is_taken(make: Any) -> None:
    with pytest.raises(TypeError, match="check_core takes a function that makes MyCore"):
        check_core(make)
    with pytest.raises(TypeError, match="check_core takes a function that makes NativeCore"):
        check_core(partial(NativeCore, "pong"), reference=make)
