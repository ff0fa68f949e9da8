"""`ObservationStack`: images from any core and from arrays, and every misuse an exception."""

import copy
import pickle
from typing import Any

import cv2
import numpy as np
import pytest
from own_process import run_program

import atari._emulator as _emulator
from atari.cores import CORES, ByteArray, NativeCore
from atari.env.settings import filled

GRAY, RGB, PAIRS = _emulator.PixelFormat.GRAY, _emulator.PixelFormat.RGB, _emulator.PixelFormat.GRAY_OF_RGB
ENDS = list(_emulator.EndFrames)


def make(rows: int = 210, tv_format: str = "NTSC", **fields: Any) -> Any:
    size = {"img_height": 84, "img_width": 84, "stack_num": 3, "padding": _emulator.Padding.ZERO}
    settings = filled(_emulator.ObservationSettings(), **{**size, **fields})
    return _emulator.ObservationStack(settings, rows, tv_format)


def started(core: str = "native", game: str = "ms_pacman", **options: Any) -> Any:
    made = CORES[core](game, seed=1, repeat_action_probability=0.0, **options)
    made.reset()
    return made


def play(stack: Any, core: Any, given: str, skips: int, beside: Any = None) -> list[ByteArray]:
    """The observations of skips of random lengths, of which some end an episode early. `beside` gets the same as arrays."""
    random = np.random.default_rng(0)
    seen = []

    def give(method: str, *arguments: Any) -> None:
        getattr(stack, method)(core if given == "core" else core.screen(), *arguments)
        if beside is not None:
            getattr(beside, method)(core.screen(), *arguments)

    def observe() -> None:
        seen.append(stack.observation())
        assert beside is None or np.array_equal(beside.observation(), seen[-1])

    give("begin")
    observe()
    for number in range(skips):
        left = skip = int(random.integers(1, 6))
        stop = int(random.integers(0, skip)) if number % 3 == 2 else 0  # as if the episode ended there
        while left > stop:
            left -= 1
            core.act(int(random.integers(18)))
            give("frame_played", left, number % 3 == 2 and left == stop)
        give("skip_ended", left, number % 3 == 2)
        observe()
        if number % 7 == 6:
            for each in filter(None, (stack, beside)):
                each.repeat(number % 2 == 0)
            observe()
    return seen


@pytest.mark.parametrize("pixels", [GRAY, RGB, PAIRS])
@pytest.mark.parametrize("ends", ENDS)
def test_all_cores_and_arrays_give_the_same(ends: Any, pixels: Any) -> None:
    fields = {"end_frames": ends, "pixels": pixels}
    expected = play(make(**fields), started(), "core", 40)
    assert len({image.tobytes() for image in expected}) > 20
    for name in ("native", "plain", "ale"):
        np.testing.assert_array_equal(play(make(**fields), started(name), "core", 40, make(**fields)), expected)


@pytest.mark.parametrize("tv_format", ["NTSC", "PAL", "SECAM"])
def test_pools_colours_as_opencv(tv_format: str) -> None:
    """All pairs of palette indices."""
    early, late = np.divmod(np.arange(256 * 256, dtype=np.int64), 256)
    colours = _emulator.palette(tv_format)
    for start in range(0, 65536, 160 * 256):
        frames = [np.resize(index[start : start + 160 * 256], (256, 160)).astype(np.uint8) for index in (early, late)]
        stack = make(256, tv_format, pixels=PAIRS, img_height=256, img_width=160, stack_num=1)
        stack.begin(frames[1])
        stack.frame_played(frames[0], 1, False)
        stack.skip_ended(frames[1], 0, False)
        expected = cv2.cvtColor(np.maximum(colours[frames[0]], colours[frames[1]]), cv2.COLOR_RGB2GRAY)
        np.testing.assert_array_equal(stack.observation()[0], expected)


@pytest.mark.parametrize("ends", ENDS)
def test_two_stacks_of_a_core_do_not_disturb_each_other(ends: Any) -> None:
    """With the end frames of Gymnasium, a stack needs frames of the step before."""
    alone = play(make(end_frames=ends), started(), "core", 30)
    core, other = started(), make(end_frames=ends, img_width=40)
    other.begin(core)

    class Both:
        screen = core.screen

        def act(self, action: int) -> None:
            core.act(action)
            other.skip_ended(core, 0, False)

    np.testing.assert_array_equal(play(make(end_frames=ends), Both(), "core", 30), alone)


def test_another_core_is_not_taken_for_the_last_one() -> None:
    stack, first, second = make(stack_num=1), started(), started(mode=1)
    for _ in range(20):
        first.act(3)
    for core in (first, second, first):
        stack.begin(core)
        image = cv2.resize(core.screen_grayscale(), (84, 84), interpolation=cv2.INTER_AREA)
        np.testing.assert_array_equal(stack.observation()[0], image)


@pytest.mark.parametrize("core", CORES)
def test_ram_of_cores_and_arrays(core: str) -> None:
    played, stacks = started(core), [make(pixels=_emulator.PixelFormat.RAM) for _ in range(2)]
    rams = [np.zeros(128, np.uint8)] * 2
    for step in range(5):
        rams.append(played.ram())
        for stack, given in zip(stacks, (played, played.ram()), strict=True):
            stack.begin(given) if step == 0 else stack.skip_ended(given, 0, False)
            assert np.array_equal(stack.observation(), rams[-3:])
        played.act(2)
    (copied := pickle.loads(pickle.dumps(stacks[0]))).repeat()
    assert np.array_equal(copied.observation(), [*rams[-2:], rams[-1]])
    for wrong in (np.zeros(127, np.uint8), np.zeros(128, np.int64), played.screen()):
        with pytest.raises(TypeError, match=r"RAM is that of a core, or a uint8 array \(128,\)"):
            copied.begin(wrong)


def test_averaged_colours() -> None:
    fields = {"color_averaging": True}
    expected = play(make(), started(**fields), "array", 20)
    np.testing.assert_array_equal(play(make(), started(**fields), "core", 20), expected)
    assert not np.array_equal(expected, play(make(), started(), "core", 20))


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda stack: pickle.loads(pickle.dumps(stack))])
@pytest.mark.parametrize("ends", ENDS)
def test_copies_and_states_continue(ends: Any, duplicate: Any) -> None:
    core, stack = started(), make(end_frames=ends)
    play(stack, core, "core", 10)
    state = core.clone_state(include_rng=True)
    copied, loaded = duplicate(stack), make(end_frames=ends)
    loaded.load(stack.save())
    results = []
    for each in (stack, copied, loaded):
        core.restore_state(state)
        core.act(2)
        each.frame_played(core, 1, False)
        core.act(3)
        each.skip_ended(core, 0, True)
        results.append(each.observation())
    np.testing.assert_array_equal(results[1], results[0])
    np.testing.assert_array_equal(results[2], results[0])


def test_wrong_arguments() -> None:
    for arguments, text in (
        ({"rows": 301}, r"rows must be within 1\.\.300"),
        ({"rows": 0}, r"rows must be within 1\.\.300"),
        ({"stack_num": 0}, r"stack_num must be within 1\.\.10000"),
        ({"img_height": 211}, "cannot be made 211 x 84"),
        ({"pixels": _emulator.PixelFormat.NONE}, "pixels must not be NONE"),
        ({"tv_format": "PAL60"}, "the TV format is NTSC, PAL or SECAM"),
    ):
        with pytest.raises(ValueError, match=text):
            make(**arguments)
    stack = make()
    for core in (started(game="carnival"), started(game="pitfall")):  # of another height; of another TV format
        other = make(250) if core.game.screen.shape[0] == 210 else stack
        with pytest.raises(
            ValueError, match=r"frames have another size or TV format than this stack's, which are 2\d0 x 160 in NTSC"
        ):
            other.begin(core)
    with pytest.raises(ValueError, match="another size or TV format"):
        make(tv_format="PAL").begin(started())
    for frame in (np.zeros((210, 160, 3), np.uint8), np.zeros((210, 160)), np.zeros((210, 320), np.uint8)[:, ::2], 3):
        for call in (stack.begin, lambda frame: stack.skip_ended(frame, 0, False)):
            with pytest.raises(TypeError, match=r"a frame is a core, or a C-contiguous uint8 array of palette indices"):
                call(frame)
    with pytest.raises(ValueError, match="the state of this stack has"):
        stack.load(b"x")
    core = started()
    core.close()
    with pytest.raises(RuntimeError, match="this core is closed"):
        stack.begin(core)


def test_calls_in_any_order_with_any_core_crash_nothing() -> None:
    run_program(
        """
        import gc, numpy as np
        import atari._emulator as _emulator
        from atari.cores import NativeCore
        from atari.env.settings import filled
        random, core = np.random.default_rng(0), None
        for ends in _emulator.EndFrames:
            for pixels in list(_emulator.PixelFormat)[1:]:
                settings = filled(_emulator.ObservationSettings(), end_frames=ends, pixels=pixels, img_height=210,
                                  img_width=int(random.choice([84, 160])))
                stack = _emulator.ObservationStack(settings, 210, "NTSC")
                for _ in range(250):
                    if random.random() < 0.02:
                        core = None
                        gc.collect()
                    if core is None or random.random() < 0.02:
                        core = NativeCore("pong", seed=0)
                    array = core.ram() if pixels == _emulator.PixelFormat.RAM else core.screen()
                    frame = [core, array, core][random.integers(3)]
                    left, ended = int(random.integers(-1, 3)), bool(random.integers(2))
                    match random.integers(8):
                        case 0: stack.begin(frame, ended)
                        case 1: stack.repeat(ended)
                        case 2 | 3: stack.frame_played(frame, left, ended)
                        case 4 | 5: stack.skip_ended(frame, left, ended)
                        case 6: stack.load(random.bytes(len(stack.save())))
                        case 7: core.act(int(random.integers(18)))
                    stack.observation()
        """
    )


def test_until_a_life_is_lost_or_the_game_ends() -> None:
    core, single = (NativeCore("breakout", seed=0, repeat_action_probability=0.0) for _ in range(2))
    for each in (core, single):
        each.reset()
    stops = []
    while not core.game_over:
        reward, played = core.act_until(1, 5)
        rewards, lives = [], single.lives
        for _ in range(5):
            rewards.append(single.act(1))
            if single.game_over or single.lives != lives:
                break
        assert (reward, played) == (sum(rewards), len(rewards))
        assert core.save() == single.save()
        stops.append(played)
    assert len(set(stops)) > 1
