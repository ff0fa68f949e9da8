"""The window and its sound, with events on SDL's dummy display and dummy audio device."""

import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pygame
import pytest
from cli_tools import Capture, Patch, refused

from atari.cli import main
from atari.play import Session, play
from atari.play.loop import Loop, Pacer
from atari.play.outputs import GameWindow, Speaker, _Lines
from atari.recording import Replay

BARE = "pong: Pong, as PongNoFrameskip-v4, but actions='full', max_num_frames_per_episode=None\n"


pytestmark = pytest.mark.usefixtures("display")


def begin() -> None:
    """Press a key without a meaning, with which the game begins at the next tick."""
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_x))


class WindowDriver:
    """A loop whose ticks the test makes."""

    def __init__(self, game: str = "breakout", *, sound: bool = False, scale: int = 1) -> None:
        self.session = Session(game, replay=Path("a.a26r"), state=Path("a.state"), videos=Path("v"), seed=1, scale=1)
        self.window = GameWindow(pygame, self.session.game, scale)
        pygame.joystick.init()
        self.speaker = Speaker(pygame, 59.92) if sound else None
        self.loop = Loop(pygame, self.session, self.window, self.speaker)
        begin()

    def tick(self, frames: int = 1) -> bool:
        return all(self.loop.tick() for _ in range(frames))

    def press(self, *keys: int, frames: int = 1) -> bool:
        """Press keys, play frames, and release the keys."""
        for key in keys:
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))
        going = self.tick(frames)
        for key in keys:
            pygame.event.post(pygame.event.Event(pygame.KEYUP, key=key))
        return going

    def close(self) -> Replay:
        self.session.close()
        return Replay.load("a.a26r")

    def shown(self) -> np.ndarray[Any, Any]:
        surface = pygame.display.get_surface()
        assert surface is not None
        return pygame.surfarray.array3d(surface).swapaxes(0, 1)


def test_keys_are_played_and_the_screen_is_shown_with_wide_pixels() -> None:
    driver = WindowDriver(scale=2)
    driver.press(pygame.K_SPACE, frames=10)
    driver.press(pygame.K_RIGHT, frames=20)
    driver.tick(5)
    assert driver.shown().shape == (420, 640, 3)
    assert np.array_equal(driver.shown(), driver.session.screen.repeat(2, axis=0).repeat(4, axis=1))
    assert pygame.display.get_caption()[0] == "Breakout   0"
    actions = [frame.action for frame in driver.close().frames()]
    assert actions == [1] * 10 + [3] * 20 + [0] * 5


def test_the_first_screen_shows_the_keys_until_one_is_pressed() -> None:
    driver = WindowDriver("pong")
    pygame.event.clear()
    for key in (pygame.K_m, pygame.K_F11, pygame.K_F11, pygame.K_h, pygame.K_h):  # commands begin no game
        driver.press(key)
    assert driver.session.frames == 0
    assert "right arrow, D, up arrow, W: RIGHT" in driver.loop._text()
    assert (driver.shown()[-60:, :100] == 255).any()
    driver.press(pygame.K_UP, frames=8)
    assert driver.loop._text() == ""
    driver.press(pygame.K_LEFT, pygame.K_UP, frames=2)
    driver.press(pygame.K_s, pygame.K_SPACE, frames=3)
    replay = driver.close()
    right, left_and_fire = 3, 12  # the game's own
    assert [frame.action for frame in replay.frames()] == [right] * 8 + [0] * 2 + [left_and_fire] * 3
    assert replay.verify("ale")


def test_a_number_switches_an_intervention() -> None:
    driver = WindowDriver("pong")
    pygame.event.clear()
    assert "I: 6 interventions, which change the game" in driver.loop._text()
    driver.press(pygame.K_3)  # without the list it is a key as any other
    driver.press(pygame.K_i)
    assert "3  off  lazy_enemy: The opponent's paddle stands still." in driver.loop._text().splitlines()
    driver.press(pygame.K_3)
    driver.press(pygame.K_9)  # there is none
    assert "3  on   lazy_enemy: The opponent's paddle stands still." in driver.loop._text().splitlines()
    driver.press(pygame.K_i)
    assert driver.loop._text() == ""
    driver.tick(30)
    assert {name for name, on in driver.session.interventions.items() if on} == {"lazy_enemy"}
    assert driver.session._atari.core.ram()[50] == 120
    driver.press(pygame.K_i)
    driver.press(pygame.K_3)
    driver.tick(30)
    assert not any(driver.session.interventions.values())
    driver.press(pygame.K_BACKSPACE, frames=12)  # to a moment with it
    driver.tick(20)
    assert driver.session.frames > 40
    assert driver.close().verify()


@pytest.mark.parametrize(
    "first",
    [
        pygame.event.Event(pygame.JOYBUTTONDOWN, button=0),
        pygame.event.Event(pygame.JOYHATMOTION, value=(0, 1)),
        pygame.event.Event(pygame.JOYAXISMOTION, axis=1, value=-1.0),
    ],
)
def test_a_gamepad_begins_the_game(first: Any) -> None:
    driver = WindowDriver("pong")
    pygame.event.clear()
    pygame.event.post(pygame.event.Event(pygame.JOYAXISMOTION, axis=1, value=-0.2))  # a worn stick
    pygame.event.post(pygame.event.Event(pygame.MOUSEMOTION))
    driver.tick(3)
    assert driver.session.frames == 0
    pygame.event.post(first)
    driver.tick(3)
    assert driver.session.frames == 3
    driver.close()


def test_pause_and_single_frames() -> None:
    driver = WindowDriver()
    driver.tick(10)
    driver.press(pygame.K_p)
    driver.tick(10)
    assert driver.session.frames == 10
    assert (driver.shown()[-32:, :300] == 255).any()  # the text
    driver.press(pygame.K_n)
    driver.press(pygame.K_n)
    assert driver.session.frames == 12
    driver.press(pygame.K_p)
    driver.tick(3)
    assert driver.session.frames == 16
    driver.close()


def test_keys_change_the_speed(monkeypatch: Patch) -> None:
    driver = WindowDriver(sound=True)
    heard: list[int] = []
    monkeypatch.setattr(driver.speaker, "play", lambda samples: heard.append(driver.session.frames))
    driver.tick(4)
    driver.press(pygame.K_PLUS)
    assert driver.loop._text() == "speed 2"
    driver.tick(9)
    assert driver.session.frames == 4 + 20
    driver.press(pygame.K_EQUALS, frames=5)
    assert driver.session.frames == 24 + 20
    for _ in range(5):  # the least is 0.25
        driver.press(pygame.K_KP_MINUS)
    before = driver.session.frames
    driver.press(pygame.K_MINUS, frames=40)
    assert driver.session.frames == before + 10
    driver.tick(200)
    assert driver.loop._text() == "speed 0.25"  # after the message, too
    assert heard == [1, 2, 3, 4, *(frame for frame in heard if frame > 44)]
    assert len(heard) <= 6
    driver.press(pygame.K_p)
    before = driver.session.frames
    driver.press(pygame.K_n)
    assert driver.session.frames == before + 1
    assert driver.loop._text() == "paused: P to go on, N for one frame; speed 0.25"
    assert driver.close().verify()


def test_the_help_is_whole_and_on_a_dark_ground() -> None:
    for scale in (1, 2, 3):
        driver = WindowDriver("pong", scale=scale)
        driver.press(pygame.K_h, frames=3)
        panel = driver.window._panel
        assert panel.get_width() <= 320 * scale
        assert panel.get_height() <= 210 * scale
        shown = driver.shown()[-panel.get_height() :, : panel.get_width()]
        assert (shown == 255).all(axis=2).any()
        assert np.median(shown.max(axis=2)) < 48  # the game's ground is lighter
        rows = np.flatnonzero((shown == 255).all(axis=2).any(axis=1))
        assert len(np.flatnonzero(np.diff(rows) > 1)) >= 13  # lines of text
        driver.close()


def test_long_lines_are_wrapped_between_words() -> None:
    pygame.font.init()
    font = pygame.font.Font(None, 20)
    words = [f"word{number}" for number in range(40)]
    lines = _Lines(font, [["1", "off", " ".join(words)], ["22", "on", "end"]], 300)
    last = [line for line, (left, _) in lines.placed if left == lines.placed[2][1][0]]
    assert " ".join(last).split() == [*words, "end"]
    assert len(last) > 5
    assert all(left + font.size(line)[0] <= 308 for line, (left, _) in lines.placed)
    assert lines.width <= 300


def test_the_game_rewinds_while_the_key_is_held() -> None:
    driver = WindowDriver()
    driver.press(pygame.K_SPACE, frames=100)
    driver.press(pygame.K_BACKSPACE, frames=18)
    assert driver.session.frames == 100
    driver.tick(10)
    replay = driver.close()
    assert replay.frames_total == 110
    assert replay.verify("ale")


def test_save_load_video_new_game_and_quit() -> None:
    driver = WindowDriver()
    driver.press(pygame.K_SPACE, frames=30)
    saved = driver.session.screen
    driver.press(pygame.K_p)
    driver.press(pygame.K_F5)
    driver.press(pygame.K_p, pygame.K_F10, frames=30)
    assert driver.session.recording
    driver.press(pygame.K_p)
    driver.press(pygame.K_F9)
    assert np.array_equal(driver.session.screen, saved)
    driver.press(pygame.K_F10)
    assert not driver.session.recording
    driver.press(pygame.K_r)
    driver.press(pygame.K_m, pygame.K_F11, pygame.K_F11)
    assert not driver.press(pygame.K_ESCAPE)
    replay = driver.close()
    assert len(replay.episodes) == 2
    assert [path.suffix for path in driver.session.files] == [".state", ".mp4"]


def test_file_errors_are_shown_and_play_continues() -> None:
    driver = WindowDriver()
    driver.tick(3)
    driver.press(pygame.K_F9)
    assert "there is no file" in driver.loop._text()
    Path("a.state").write_bytes(b"nonsense")
    driver.press(pygame.K_F9)
    assert "are not a snapshot" in driver.loop._text()
    Path("v").touch()
    driver.press(pygame.K_F10)
    assert driver.loop._text()
    driver.tick(150)
    assert driver.loop._text() == ""
    driver.close()


def test_the_end_of_the_game_is_shown() -> None:
    driver = WindowDriver()
    for _ in range(200):
        if driver.session.over:
            break
        driver.press(pygame.K_SPACE, frames=30)
    assert "game over" in driver.loop._text()
    driver.press(pygame.K_r)
    assert driver.loop._text() == ""
    driver.close()


def test_the_window_can_have_any_size() -> None:
    driver = WindowDriver()
    pygame.display.set_mode((700, 300), pygame.RESIZABLE)
    driver.tick(2)
    shown = driver.shown()
    columns = np.flatnonzero(shown.any(axis=(0, 2)))
    height, width = 300, round(320 * 300 / 210)
    assert shown.shape == (height, 700, 3)
    assert abs(np.ptp(columns) + 1 - width) <= 24  # Breakout's own left edge is black
    driver.close()


def test_sound_is_what_the_game_makes(monkeypatch: Patch) -> None:
    blocks: list[bytes] = []

    class Channel:
        def __init__(self, number: int) -> None:
            self.queued: Any = None

        def get_busy(self) -> bool:
            return bool(blocks)

        def get_queue(self) -> Any:
            return None

        def play(self, sound: Any) -> None:
            blocks.append(sound.get_raw())

        queue = play

    monkeypatch.setattr(pygame.mixer, "Channel", Channel)
    driver = WindowDriver("ms_pacman", sound=True)
    assert pygame.mixer.get_init() == (30679, -16, 1)
    heard = []
    for _ in range(60):
        driver.press(pygame.K_SPACE)
        heard.append(driver.session.samples)
    samples = np.concatenate([np.frombuffer(block, np.int16) for block in blocks])
    assert np.array_equal(samples, (np.concatenate(heard).astype(int) - 128) * 128)
    assert samples.any()
    driver.press(pygame.K_m, frames=6)
    blocks.clear()
    driver.tick(9)
    assert not np.concatenate([np.frombuffer(block, np.int16) for block in blocks]).any()
    driver.close()


def test_sound_that_comes_too_early_is_not_kept_for_ever() -> None:
    speaker = Speaker(pygame, 59.92)
    for _ in range(300):
        speaker.play(np.full(512, 130, np.uint8))
    assert len(speaker._waiting) == 2
    assert speaker._channel.get_busy()
    speaker.close()


def test_without_a_sound_card_it_is_silent(monkeypatch: Patch) -> None:
    monkeypatch.setenv("SDL_AUDIODRIVER", "none_such")
    driver = WindowDriver(sound=True)
    driver.tick(5)
    assert driver.loop._text().startswith("no sound: ")
    driver.close()


def test_frames_come_at_the_consoles_rate_on_average() -> None:
    now = [100.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds + 0.0005  # the jitter of a sleep

    pacer = Pacer(59.92, lambda: now[0], sleep)
    for frame in range(600):
        now[0] += 0.004 if frame % 7 else 0.02
        pacer.wait()
    assert now[0] - 100 == pytest.approx(600 / 59.92, abs=0.02)
    now[0] += 5  # the computer was suspended
    before = now[0]
    for _ in range(60):
        pacer.wait()
    assert now[0] - before == pytest.approx(59 / 59.92, abs=0.03)


def test_play_runs_until_the_window_is_closed() -> None:
    session = Session("pong", replay=Path("a.a26r"))
    pygame.init()
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    play(session, scale=1, sound=True)
    assert pygame.display.get_surface() is None
    session.close()
    assert session.frames == 0


def test_the_command_writes_a_replay(end_after: Any, capsys: Capture) -> None:
    end_after(30)
    assert main(["play", "pong", "--scale", "1", "--no-sound"]) == 0
    (path,) = Path("replays").iterdir()
    assert path.name.startswith("pong-")
    assert capsys.readouterr().out == f"{BARE}Pong: 30 frames, best score 0\n  {path.resolve()}\n"
    assert Replay.load(path).verify("ale")


def test_the_command_plays_what_an_id_says(end_after: Any, capsys: Capture) -> None:
    end_after(30)
    words = ["--scale", "1", "--no-sound", "--replay", "a.a26r", "--mode", "1", "--seed", "4294967295"]
    assert main(["play", "Pong-ram-v0", *words]) == 0
    assert capsys.readouterr().out.startswith("pong: Pong, as Pong-v0, but mode=1, without obs_type='ram'\nPong: 30 f")
    task = Replay.load("a.a26r").task
    assert (task.repeat_action_probability, task.frameskip, task.mode) == (0.25, (2, 5), 1)
    assert (task.actions, task.max_num_frames_per_episode, task.obs_type) == ("minimal", 108_000, "rgb")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--continuous"], "has no place for --continuous, the field 'continuous' of a task"),
        (["--stack-num", "4"], "has no place for --stack-num, the field 'stack_num' of a task"),
        (["--obs-type", "ram"], "--obs-type needs --players"),
        (["--noops", "3"], "noops must be (low, high)"),
    ],
)
def test_flags_without_a_meaning(words: list[str], text: str, capsys: Capture) -> None:
    refused(capsys, ["play", "pong", *words], text, 1 if "--obs-type" in words else 2)


def test_no_frame_no_file(monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.setattr(Loop, "run", lambda loop: None)
    for words in (["--replay", "a.a26r"], ["--replay", "a/b/c.a26r"], ["--no-replay"], []):
        assert main(["play", "pong", "--scale", "1", "--no-sound", *words]) == 0
        assert not list(Path().iterdir())
        no_replay = "" if words == ["--no-replay"] else ", and no replay was written"
        assert capsys.readouterr().out == f"{BARE}Pong: nothing was played{no_replay}\n"


def test_without_a_frame_only_folders_that_were_made_for_it_go(monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.setattr(Loop, "run", lambda loop: loop._session.save())
    Path("replays").mkdir()
    assert main(["play", "pong", "--scale", "1", "--no-sound"]) == 0
    assert capsys.readouterr().out.endswith(f"\n  {Path('states/pong.state').resolve()}\n")
    assert main(["play", "pong", "--scale", "1", "--no-sound", "--replay", "a/b.a26r", "--state", "a/c.state"]) == 0
    assert sorted(map(str, Path().rglob("*"))) == ["a", "a/c.state", "replays", "states", "states/pong.state"]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["pnog"], "did you mean 'pong'?"),
        (["pong", "--mode", "77"], "pong has no mode 77; it has 0"),
        (["pong", "--replay", "a.mp4"], "must end in '.a26r'"),
    ],
)
def test_wrong_words_are_one_line(words: list[str], text: str, capsys: Capture) -> None:
    refused(capsys, ["play", *words], text)
    assert not list(Path().iterdir())


def test_without_pygame_the_extra_is_named(monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    refused(capsys, ["play", "pong"], "pip install 'pygame-ce>=2.4'")
    assert not list(Path().iterdir())


@pytest.mark.parametrize(("driver", "options"), [(None, []), ("x11", ["--replay", "best.a26r"])])
def test_without_a_display_it_raises_and_touches_no_file(
    driver: str | None, options: list[str], monkeypatch: Patch, capsys: Capture
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    if driver:
        monkeypatch.setenv("SDL_VIDEODRIVER", driver)
    Path("best.a26r").write_bytes(b"of yesterday")
    assert main(["play", "pong", *options]) == 1
    err = capsys.readouterr().err
    assert "atari: error: playing needs a display, and there is none (" in err
    assert "use `atari record`" in err
    assert {path.name: path.read_bytes() for path in Path().iterdir()} == {"best.a26r": b"of yesterday"}


def test_a_display_that_is_lost_is_an_error_of_gymnasium(monkeypatch: Patch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "none_such")
    with pytest.raises(gymnasium.error.Error, match="playing needs a display"):
        GameWindow(pygame, Session("pong").game, 1)
