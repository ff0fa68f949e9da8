"""`AlgorithmicEnv`: read characters from an input, write others to an output tape.

The agent observes the character under its read head. An action moves the head, and may write a character. Each right
character is a point; a wrong one ends the episode. A task defines the target.

The class also shows how to write a `gymnasium.Env`: spaces in `__init__`, the start of an episode in `reset`, its rules
in `step`, randomness from `self.np_random` alone, and a text of the state in `render`.
"""

from abc import abstractmethod
from typing import Any, ClassVar, Literal

import gymnasium
from gymnasium import spaces
from gymnasium.utils import colorize

from atari.base.validation import check_integer

Action = tuple[int, int, int]
"""Movement, an index into `moves`; 1 to write and 0 not to; the character."""

Rows = list[list[int]]
"""An input: rows of characters, all of the same length."""

MOVES = {"left": (-1, 0), "right": (1, 0), "up": (0, -1), "down": (0, 1)}
"""A movement of the read head, columns and rows."""


MAX_LENGTH = 30
"""No input is drawn from a greater minimal length."""

MARGIN = 2
"""Blanks on either side of a rendered input."""


class Curriculum:
    """The minimal length of inputs: after enough solved episodes in a row, they become longer by one character.

    Args:
        length: the initial minimal length.
        window: the number of solved episodes in a row after which it grows.
    """

    def __init__(self, length: int, window: int) -> None:
        self.length = length
        self._window = window
        self._streak = 0

    def record(self, solved: bool) -> None:
        """Count an episode."""
        self._streak = self._streak + 1 if solved else 0
        if self._streak == self._window and self.length < MAX_LENGTH:
            self.length += 1
            self._streak = 0


class AlgorithmicEnv(gymnasium.Env[Any, Any]):
    """The rules that all algorithmic tasks share.

    Args:
        base: the number of different characters, 1 to the size of the alphabet.
        min_length: the shortest input at first, 1 to 30; the longest has two characters more.
        render_mode: "ansi" returns a text from `render`, "human" prints it after each step.

    Observations are characters, 0 to base - 1, or base where the input has none. Actions are tuples of movement,
    whether to write (0 or 1) and character.

    Rewards are 1 for a right character, -0.5 for a wrong one, which ends the episode, -1 for running out of time, which
    ends it too, and else 0.

    After `window` solved episodes in a row, the inputs grow by one character. A `reset` with a seed starts from
    `min_length` again, so that equal seeds and actions give equal episodes.

    `reset` and `step` return with `info`: `input` and `target` as text, `read_head` (column, row), `write_head` (the
    number of written characters), `time` and `time_limit` in steps, `min_length` and `solved`.

    Raises:
        TypeError, ValueError: an option is not an integer, or out of range.

    Example:
        >>> import gymnasium
        >>> import atari
        >>> env = gymnasium.make("Copy-v0")
        >>> observation, info = env.reset(seed=0)
        >>> env.step((1, 1, observation))[1]
        1.0
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "ansi"], "render_fps": 4}  # noqa: RUF012
    moves: ClassVar[tuple[str, ...]]
    """The movements, in the order of the first part of an action."""
    alphabet: ClassVar[str]
    """The characters as text."""
    height: int = 1
    """The number of rows of an input."""
    window: ClassVar[int] = 10
    """The number of solved episodes in a row after which inputs grow."""

    rows: Rows
    target: list[int]
    read_head: tuple[int, int]
    write_head: int
    time: int
    action: Action | None
    reward: float
    total_reward: float
    solved: bool

    def __init__(self, base: int = 5, min_length: int = 2, render_mode: Literal["human", "ansi"] | None = None) -> None:
        base = check_integer("base", base, 1, len(self.alphabet))
        min_length = check_integer("min_length", min_length, 1, MAX_LENGTH)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode is 'human', 'ansi' or None, got {render_mode!r}")
        self.base = base
        self.render_mode = render_mode
        self.observation_space = spaces.Discrete(base + 1)
        self.action_space = spaces.Tuple((spaces.Discrete(len(self.moves)), spaces.Discrete(2), spaces.Discrete(base)))
        self._first_length = min_length
        self._curriculum = Curriculum(min_length, self.window)
        self._playing = False
        self._begin([[]], [])

    @abstractmethod
    def draw(self, length: int) -> Rows:
        """Draw an input of about this length from `self.np_random`."""

    @abstractmethod
    def solve(self, rows: Rows) -> list[int]:
        """The characters that must be written for an input."""

    @property
    def time_limit(self) -> int:
        """The number of steps allowed for the current input."""
        return len(self.rows[0]) + len(self.target) + 4

    @property
    def min_length(self) -> int:
        """The shortest input at present; it grows with success."""
        return self._curriculum.length

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        """Start an episode with a new input.

        Args:
            seed: restarts the generator and the growth of inputs.
            options: {"input": text} sets the input, in the form of `info["input"]`.

        Raises:
            TypeError: there is no such option.
            ValueError: `options["input"]` is not such a text.
        """
        for name in options or {}:
            if name != "input":
                raise TypeError(f"reset has no option {name!r} here; it has 'input', a text as in info['input']")
        given = self._parse(options["input"]) if options and "input" in options else None
        super().reset(seed=seed)
        if seed is not None:
            self._curriculum = Curriculum(self._first_length, self.window)
        elif self.time > 0:
            self._curriculum.record(self.solved)  # an abandoned episode counts as unsolved
        rows = given or self.draw(self.min_length + int(self.np_random.integers(3)))
        self._begin(rows, self.solve(rows))
        self._playing = True
        self._print()
        return self.read(*self.read_head), self._info()

    def step(self, action: Action) -> tuple[int, float, bool, bool, dict[str, Any]]:
        """Write a character if the action does, then move the read head.

        Raises:
            gymnasium.error.ResetNeeded: before the first `reset`, and after the end of an episode.
            ValueError: the action is not in the action space.
        """
        if not self._playing:
            raise gymnasium.error.ResetNeeded("no episode is going on; call env.reset() before env.step()")
        if not self.action_space.contains(action):
            raise ValueError(
                f"an action is (movement 0..{len(self.moves) - 1}, write 0..1, character 0..{self.base - 1}), "
                f"got {action!r}"
            )
        move, write, character = map(int, action)
        self.action = move, write, character
        self.time += 1
        self.reward = self._write(character) if write else 0.0
        right, down = MOVES[self.moves[move]]
        self.read_head = self.read_head[0] + right, self.read_head[1] + down
        if self.time > self.time_limit:
            self.reward = -1.0
        self.total_reward += self.reward
        self.solved = self.write_head == len(self.target) and self.reward > 0
        self._playing = not (self.solved or self.reward < 0)
        self._print()
        return self.read(*self.read_head), self.reward, not self._playing, False, self._info()

    def read(self, column: int, row: int) -> int:
        """The character at a position of the input, `base` outside of it."""
        inside = 0 <= row < len(self.rows) and 0 <= column < len(self.rows[row])
        return self.rows[row][column] if inside else self.base

    def spell(self, characters: list[int]) -> str:
        """Characters as text; `base` is a blank."""
        letters = self.alphabet[: self.base].ljust(self.base + 1)
        return "".join(letters[character] for character in characters)

    def render(self) -> str | None:
        """The current state as text with render mode "ansi"; None with "human", which prints it at each step.

        Raises:
            gymnasium.error.Error: there is no render mode.
        """
        if self.render_mode is None:
            raise gymnasium.error.Error(
                "render() needs a render mode; make the environment with render_mode='ansi' or 'human'"
            )
        return show(self) if self.render_mode == "ansi" else None

    def _begin(self, rows: Rows, target: list[int]) -> None:
        self.rows = rows
        self.target = target
        self._texts = {"input": "\n".join(map(self.spell, rows)), "target": self.spell(target)}
        self.read_head = 0, 0
        self.write_head = 0
        self.time = 0
        self.action = None
        self.reward = self.total_reward = 0.0
        self.solved = False

    def _write(self, character: int) -> float:
        right = character == self.target[self.write_head]
        self.write_head += 1
        return 1.0 if right else -0.5

    def _parse(self, given: Any) -> Rows:
        known = self.alphabet[: self.base]
        lines = given.split("\n") if isinstance(given, str) else []
        even = len(lines) == self.height and len({len(line) for line in lines}) == 1
        if not even or not lines[0] or not set("".join(lines)) <= set(known):
            raise ValueError(
                f"options['input'] is {self.height} line(s) of equal length, made of {known!r}, got {given!r}"
            )
        return [[known.index(character) for character in line] for line in lines]

    def _info(self) -> dict[str, Any]:
        return {
            **self._texts,
            "read_head": self.read_head,
            "write_head": self.write_head,
            "time": self.time,
            "time_limit": self.time_limit,
            "min_length": self.min_length,
            "solved": self.solved,
        }

    def _print(self) -> None:
        if self.render_mode == "human":
            print(show(self))


def show(env: AlgorithmicEnv) -> str:
    """The state of an environment as lines of text, with the labels and colours of OpenAI Gym's screenshots."""
    title = f"Total length of input instance: {len(env.rows[0])}, step: {env.time}"
    return "\n".join([title, "=" * len(title), *_input(env), *_output(env), "", *_last_step(env)]) + "\n"


def _input(env: AlgorithmicEnv) -> list[str]:
    label = "Observation Tape" if env.height == 1 else "Observation Grid"
    above = 0 if env.height == 1 else 1
    lines: list[str] = []
    for row in range(-above, env.height + above):
        places = [(column, row) for column in range(-MARGIN, len(env.rows[0]) + MARGIN)]
        cells = [env.spell([env.read(*place)]) for place in places]
        if env.read_head in places:
            head = places.index(env.read_head)
            cells[head] = colorize(cells[head], "green", highlight=True)
        lines.append(_line("" if lines else label, "".join(cells)))
    return lines


def _output(env: AlgorithmicEnv) -> list[str]:
    written = env.spell(env.target[: env.write_head])
    if env.action is not None and env.action[1]:
        character = env.action[2]
        color = "green" if character == env.target[env.write_head - 1] else "red"
        written = written[:-1] + colorize(env.spell([character]), color, highlight=True)
    margin = " " * MARGIN
    return [_line("Output Tape", margin + written), _line("Targets", margin + env.spell(env.target))]


def _last_step(env: AlgorithmicEnv) -> list[str]:
    if env.action is None:
        return []
    move, write, character = env.action
    return [
        _line("Current reward", f"{env.reward:.3f}"),
        _line("Cumulative reward", f"{env.total_reward:.3f}"),
        _line("Action", f"Tuple(move over input: {env.moves[move]},"),
        _line("", f"      write to the output tape: {bool(write)},"),
        _line("", f"      prediction: {env.spell([character])})"),
    ]


def _line(label: str, content: str) -> str:
    return f"{label:<20}: {content}" if label else " " * 22 + content
