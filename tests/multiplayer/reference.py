"""A game of several players, played step by step by a core alone."""

from typing import Any

import cv2
import numpy as np

from atari.multiplayer import MultiplayerCore


class Reference:
    """One game in steps of four frames, with the preprocessing in NumPy and OpenCV.

    `fill` begins a stack with copies of the first image, not with black ones. `images` is whether there are any.
    """

    def __init__(
        self,
        game: str,
        players: int,
        frames: int = 108_000,
        *,
        full: bool = False,
        fill: bool = False,
        images: bool = True,
        **options: Any,
    ) -> None:
        self.core = MultiplayerCore(game, players=players, **options)
        actions = range(18) if full else self.core.rules.minimal_actions
        self.actions = [int(action) for action in actions]
        self.limit = frames
        self.ended, self.fill, self.images = False, fill, images

    def reset(self, seed: int | None = None) -> None:
        if seed is not None:
            self.core.seed(seed)
        self.core.reset()
        self.frames, self.ended = 0, False
        self.out = np.zeros(self.core.players, np.bool_)
        self.stack = np.zeros((4, 84, 84), np.uint8)
        for _ in range(4 if self.fill else 1):
            self.push(self.core.screen_grayscale())
        self.signals = np.zeros(self.core.players), self.out.copy(), self.out.copy()

    def push(self, screen: Any) -> None:
        if not self.images:
            return
        image = cv2.resize(screen, (84, 84), interpolation=cv2.INTER_AREA)
        self.stack = np.concatenate([self.stack[1:], image[None]])

    def step(self, indices: Any) -> None:
        was_out = self.out.copy()
        held = [self.actions[0 if out else index] for index, out in zip(indices, was_out, strict=True)]
        rewards, screens = np.zeros(self.core.players), []
        while len(screens) < 4 and not self.ended:
            rewards += self.core.act_players(held)
            screens.append(self.core.screen_grayscale())
            self.frames += 1
            self.out |= np.array(self.core.player_lives) < 0
            over = self.core.game_over or self.out.all()
            self.ended = over or self.frames >= self.limit
        self.push(np.maximum(*screens[2:]) if len(screens) == 4 else screens[-1])
        rewards[was_out] = 0
        self.signals = rewards, self.out | over, np.array([self.ended and not over] * len(rewards)) & ~self.out
