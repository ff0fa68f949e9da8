"""`play` and `show_replay`: the main loop of a game or of a replay in a window, at the console's speed."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from typing import Any

import gymnasium

from atari.games.game import Game
from atari.games.interventions import load
from atari.play.base import BaseSession
from atari.play.controls import Command, SharedControls, Speed, command_of, first_screen
from atari.play.outputs import GameWindow, Speaker, start_pygame
from atari.recording import Replay
from atari.recording.video.writer import frame_rate

_MESSAGE_SECONDS = 2.0
_FRAMES_PER_REWIND = 6
_MAX_LAG = 0.25  # seconds; after a longer delay the lost time is dropped


class Pacer:
    """A clock that waits between frames, so that the average rate is `frames_per_second`."""

    def __init__(
        self,
        frames_per_second: float,
        now: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._period = 1 / frames_per_second
        self._now, self._sleep = now, sleep
        self._due = now()

    def wait(self) -> None:
        """Wait until it is time for the next frame."""
        self._due += self._period
        left = self._due - self._now()
        if left > 0:
            self._sleep(left)
        elif left < -_MAX_LAG:
            self._due = self._now()


def play(session: BaseSession, *, scale: int = 3, sound: bool = True, full_screen: bool = False) -> None:
    """Play in a window until it is closed. `controls.HELP` and `HELP_SEVERAL` list the keys. The session stays open.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
        gymnasium.error.Error: there is no display.
    """
    with _outputs(session.game, scale, sound, full_screen) as (pygame, window, speaker):
        pygame.joystick.init()
        try:
            Loop(pygame, session, window, speaker).run()
        finally:
            pygame.joystick.quit()


def show_replay(replay: Replay, *, scale: int = 3, sound: bool = True) -> bool:
    """Show a replay until its end, a closed window or the Escape key; returns whether it reached its end.

    The keys + and - change the speed; sound is played at the console's speed.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
        gymnasium.error.Error: there is no display.
    """
    with _outputs(replay.game, scale, sound) as (pygame, window, speaker):
        pacer, speed, score = Pacer(float(frame_rate(replay.game))), Speed(), 0
        frames, left = replay.frames(sound=sound), replay.frames_total
        while left:
            for event in pygame.event.get():
                command = command_of(pygame, event)
                if command == Command.QUIT:
                    return False
                speed.change(command)
            for frame in islice(frames, speed.frames()):
                left -= 1
                score += frame.reward
                if speaker is not None and speed.usual:
                    speaker.play(frame.audio)
                shown = frame.screen
            window.show(shown, f"{replay.game.title}: {score:,}", "" if speed.usual else str(speed))
            pacer.wait()
    return True


@contextmanager
def _outputs(
    game: Game, scale: int, sound: bool, full_screen: bool = False
) -> Iterator[tuple[Any, GameWindow, Speaker | None]]:
    pygame = start_pygame()
    window = GameWindow(pygame, game, scale, full_screen=full_screen)
    speaker = Speaker(pygame, float(frame_rate(game))) if sound else None
    try:
        yield pygame, window, speaker
    finally:
        if speaker is not None:
            speaker.close()
        window.close()


class Loop:
    """The work of each tick: handle events, play or rewind a frame, show it and play its sound.

    If a person plays, the game waits at its first screen, which shows the keys, until a key or a gamepad is pressed
    that gives no command.
    """

    def __init__(self, pygame: Any, session: BaseSession, window: GameWindow, speaker: Speaker | None) -> None:
        self._pygame, self._session, self._window, self._speaker = pygame, session, window, speaker
        paddles = session.game.controllers.paddles
        self._controls = SharedControls(pygame, [player + 1 for player in session.humans], paddles=paddles)
        interventions = len(session.interventions)
        self._first_screen = first_screen(session.game, session.minimal_actions, self._controls.layouts, interventions)
        self._waiting = bool(session.humans)
        self._gamepads: dict[int, Any] = {}
        self._paused = self._single = self._helping = self._listing = False
        self._ticks, self._speed = 0, Speed()
        self._rate = float(frame_rate(session.game))
        self._message, self._message_until = "", 0
        silent = f"no sound: {speaker.error}" if speaker is not None and speaker.error is not None else ""
        self._show_message("   ".join(filter(None, (silent, self._controls.note))))

    def run(self) -> None:
        """Run ticks until the window is closed."""
        pacer = Pacer(self._rate)
        while self.tick():
            pacer.wait()

    def tick(self) -> bool:
        """Handle one frame, and return False when the window is closed."""
        self._ticks += 1
        for event in self._pygame.event.get():
            if event.type == self._pygame.JOYDEVICEADDED:  # SDL also sends it for the gamepads present at the start
                gamepad = self._pygame.joystick.Joystick(event.device_index)
                self._gamepads[gamepad.get_instance_id()] = gamepad
                self._show_message(self._controls.add_gamepad(gamepad.get_instance_id()))
            if self._listing and (digit := self._controls.digit(event)) is not None:
                self._show_errors(lambda digit=digit: self._toggle_intervention(digit))  # type: ignore[misc]
                continue
            command = self._controls.handle(event)
            if command == Command.QUIT:
                return False
            if command is None:
                self._waiting &= not self._controls.presses(event)
            else:
                self._show_errors(lambda command=command: self._run_command(command))  # type: ignore[misc]
        if self._controls.rewinding:
            if self._ticks % _FRAMES_PER_REWIND == 0:
                self._session.rewind()
        elif self._single or not self._paused:
            for _ in range(1 if self._single else self._speed.frames()):
                self._show_errors(self._play)
            self._single = False
        self._window.show(self._session.screen, self._session.title, self._text())
        return True

    def _play(self) -> None:
        if self._waiting or self._session.over:
            return
        self._session.play(*self._controls.actions(self._session.legal_actions))
        if self._speaker is not None and self._speed.usual:
            self._speaker.play(self._session.samples)

    def _run_command(self, command: Command) -> None:
        session = self._session
        if self._speed.change(command):
            self._show_message(str(self._speed))
        elif command == Command.PAUSE:
            self._paused = not self._paused
        elif command == Command.FRAME:
            self._single = self._paused
        elif command == Command.NEW_GAME:
            session.new_game()
        elif command == Command.SAVE:
            self._show_message(f"saved as {session.save()}")
        elif command == Command.LOAD:
            session.load()
            self._show_message("loaded")
        elif command == Command.VIDEO:
            path = session.toggle_video()
            self._show_message(f"recording {path}" if path else "the video is complete")
        elif command == Command.FULL_SCREEN:
            self._window.toggle_full_screen()
        elif command == Command.MUTE and self._speaker is not None:
            self._speaker.muted = not self._speaker.muted
        elif command == Command.HELP:
            self._helping, self._listing = not self._helping, False
        elif command == Command.INTERVENTIONS:
            self._listing, self._helping = bool(session.interventions) and not self._listing, False
            if not session.interventions:
                self._show_message("no interventions to switch")

    def _toggle_intervention(self, digit: int) -> None:
        """Switch the intervention whose number in the list is a digit, if there is one."""
        names = list(self._session.interventions)
        if 0 < digit <= len(names):
            self._session.toggle_intervention(names[digit - 1])

    def _interventions(self) -> str:
        """The list of interventions: the number, whether it is on, the name, and what it changes."""
        known = load(self._session.game)
        lines = [
            f"{number}  {'on ' if on else 'off'}  {name}: {known[name].description}"
            for number, (name, on) in enumerate(self._session.interventions.items(), 1)
        ]
        return "\n".join(["a number switches one, I closes the list", *lines])

    def _show_errors(self, work: Callable[[], None]) -> None:
        try:
            work()
        except (OSError, ValueError, gymnasium.error.Error) as error:
            text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
            self._show_message(text)

    def _show_message(self, message: str) -> None:
        self._message = message
        self._message_until = self._ticks + round(_MESSAGE_SECONDS * self._rate)

    def _text(self) -> str:
        session = self._session
        state = ""
        if self._controls.rewinding:
            state = "going back"
        elif session.over:
            state = "game over: R for a new game, backspace to go back"
        elif self._paused:
            state = "paused: P to go on, N for one frame"
        message = self._message if self._ticks < self._message_until else ""
        changed = "" if self._speed.usual or message == str(self._speed) else str(self._speed)
        recording = "REC" if session.recording else ""
        line = "; ".join(part for part in (recording, state, changed, message) if part)
        keys = self._controls.help if self._helping else self._first_screen if self._waiting else ""
        keys = self._interventions() if self._listing else keys
        return "\n".join(filter(None, (keys, line)))
