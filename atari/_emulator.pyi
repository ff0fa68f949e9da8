"""
The binding of the native emulator. Use it through atari.cores.NativeCore, which checks options and
finds ROMs.
"""

from collections.abc import Sequence
import enum
from typing import Any

import numpy
import numpy.typing

def report_leaks() -> None:
    """Print the objects that still exist when the interpreter has ended."""

END: int = 40

class Game:
    """
    A game, compiled: cartridge, console, rules. Immutable; emulators share it.
    """

    @property
    def cartridge_type(self) -> str:
        """The bank switching, given or recognised, such as "F8"."""

def simd_level() -> str:
    """
    The level of SIMD instructions that is used. Raises ValueError if the environment variable ATARI_SIMD is wrong.
    """

def make_game(
    *,
    image: bytes,
    cartridge: str,
    format: str,
    detect_format: bool,
    first_line: int,
    height: int,
    hmove_blanks: bool,
    paddles: tuple[bool, bool],
    swap_ports: bool,
    swap_paddles: bool,
    paddle_range: tuple[int, int],
    power_on_switches: int,
    legal_actions: Sequence[int],
    starting_actions: Sequence[int],
    default_mode: int,
    variables: int,
    initial: Sequence[int],
    kept: Sequence[bool],
    outputs: Sequence[int],
    step: Sequence[int],
    select_mode: Sequence[int],
) -> Game:
    """
    Check and assemble a game; raises ValueError if the image or a rule program is not sound.
    """

STATE_VERSION: int = 3

class State:
    """
    A state in memory: the result of `Emulator.clone_state`, or read from the bytes of
    `serialize`. Immutable. Two states are equal if their bytes of `serialize` are equal.
    """

    def __init__(self, serialized: bytes) -> None: ...
    def serialize(self) -> bytes:
        """The state as bytes, for this release and machine."""

    def equals(self, other: State) -> bool: ...
    def __eq__(self, other: object) -> bool: ...
    def __ne__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...
    def __copy__(self) -> State: ...
    def __deepcopy__(self, memo: object) -> State: ...
    def __getstate__(self) -> bytes: ...
    def __setstate__(self, arg: bytes, /) -> None: ...
    def getFrameNumber(self) -> int: ...
    def getEpisodeFrameNumber(self) -> int: ...
    def getCurrentMode(self) -> int: ...
    def getDifficulty(self) -> int: ...

class Write:
    """A write to RAM, compiled. Immutable; emulators share it."""

    @property
    def definition(self) -> str:
        """The text that `make_write` was given."""

    @property
    def label_values(self) -> list[int]:
        """
        The value of the label for each byte; empty if it depends on other bytes, or there is no label.
        """

MOST_WRITES: int = 64

def make_write(
    *,
    index: int,
    mask: int,
    every_frame: bool,
    at_reset: bool,
    frames: Sequence[int],
    once: bool,
    paid: bool,
    remembers: bool,
    condition: Sequence[int],
    value: Sequence[int],
    label: Sequence[int],
    definition: str,
) -> Write:
    """
    Check and assemble a write; raises ValueError if a program is not sound.
    """

class Emulator:
    """
    A running game. It releases Python's interpreter lock while it emulates.
    """

    def __init__(
        self,
        *,
        game: Game,
        repeat_action_probability: float,
        frame_skip: int,
        max_num_frames_per_episode: int,
        sound: bool,
        color_averaging: bool,
        seed: int,
        plain: bool = False,
        one_generator: bool = False,
        second_player_starts: bool = False,
        player_probabilities: Sequence[float] = [],
    ) -> None:
        """
        `plain`: the plain interpreter and TIA play, which are slower and give the same results.
        """

    def seed(self, seed: int) -> None: ...
    def reset(self) -> None: ...
    def act(self, action: int, strength: float = 1.0) -> int: ...
    def act_until(self, action: int, frames: int, strength: float = 1.0) -> tuple[int, int]:
        """
        Play until the game is over or truncated or the number of lives changes, but at most `frames` frames.
        Returns the sum of the rewards and the number of frames played.
        """

    def act_players(self, actions: Sequence[int]) -> list[int]:
        """
        Hold an action for each of the first players; returns a reward for each.
        """

    @property
    def player_lives(self) -> list[int]:
        """The lives of each player that the rules know."""

    @property
    def mode(self) -> int: ...
    @property
    def difficulty(self) -> int: ...
    def set_mode(self, mode: int) -> None: ...
    def set_difficulty(self, difficulty: int) -> None: ...
    @property
    def lives(self) -> int: ...
    @property
    def game_over(self) -> bool: ...
    @property
    def truncated(self) -> bool: ...
    @property
    def frame_number(self) -> int: ...
    @property
    def episode_frame_number(self) -> int: ...
    def ram(self, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]: ...
    def audio(self, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]: ...
    def screen(self, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]: ...
    def screen_rgb(self, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]: ...
    def screen_grayscale(
        self, out: numpy.typing.NDArray[numpy.uint8] | None = None
    ) -> numpy.typing.NDArray[numpy.uint8]: ...
    def set_ram(self, index: int, value: int) -> None: ...
    def redraw(self, out: numpy.typing.NDArray[numpy.uint8] | None = None) -> numpy.typing.NDArray[numpy.uint8]: ...
    def add_write(self, write: Write, now: bool = False) -> None:
        """
        Apply a write at each later frame, and with `now` at once; ValueError if there are MOST_WRITES.
        """

    def remove_write(self, write: Write) -> int:
        """End a write; returns its slot, or -1."""

    @property
    def writes(self) -> list[Write | None]:
        """
        The writes by slot; None for a slot whose write has ended. They are applied in this order.
        """

    @writes.setter
    def writes(self, arg: Sequence[Write | None], /) -> None: ...
    def save(self) -> bytes:
        """The whole state as bytes, in the layout of this build."""

    def load(self, state: bytes) -> None:
        """Continue from `save`; ValueError if the bytes cannot be a state."""

    def clone_state(self, include_rng: bool = False) -> State:
        """
        The whole state in memory; `include_rng` says whether the state includes the generator.
        """

    def restore_state(self, state: State) -> None:
        """
        Continue from a state of `clone_state`; ValueError if the state belongs to another game or core.
        """

    def close(self) -> None: ...

def palette(format: str) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Red, green and blue of the 256 palette indices of a TV format, (256, 3).
    """

def translator() -> str | None:
    """
    The processor for which cartridges are translated, "x86-64" or "arm64"; None if handlers run all code.
    Raises ValueError if the environment variable ATARI_JIT is wrong.
    """

class RewardFormula:
    """
    The reward of a task as an expression, compiled. Immutable; environments share it.
    """

    def __init__(
        self, terms: Sequence[int], visibility: Sequence[int], words: Sequence[int], constants: Sequence[float]
    ) -> None:
        """
        `terms` is the program of the terms, and `visibility` has for each the term with its visibility, or -1.
        `words` are the operations of the formula, each with its argument.
        """

    @property
    def inputs(self) -> int:
        """The number of inputs, which are the state between two steps."""

    def begin(
        self, inputs: numpy.typing.NDArray[numpy.float64], ram: numpy.typing.NDArray[numpy.uint8], lives: int
    ) -> None:
        """Set the inputs after a reset."""

    def pay(
        self,
        inputs: numpy.typing.NDArray[numpy.float64],
        ram: numpy.typing.NDArray[numpy.uint8],
        lives: int,
        game_reward: float,
    ) -> float:
        """The reward of a step; sets the inputs after it."""

class FirePress(enum.Enum):
    """When FIRE is pressed at the start of an episode."""

    NEVER = 0

    BEFORE_NOOPS = 1

    AFTER_NOOPS = 2

class OnReset(enum.Enum):
    """The effect of a reset after a lost life."""

    NOOP = 0

    CONTINUE = 1

    NEW_GAME = 2

class Unit(enum.Enum):
    """
    How long FIRE is pressed, and how often lives are compared: a frame, or a whole skip.
    """

    FRAME = 0

    SKIP = 1

class Seeding(enum.Enum):
    """
    How generators are seeded: like AtariEnv.reset, or like ale-py's vector.
    """

    GYMNASIUM = 0

    ALE = 1

class PixelFormat(enum.Enum):
    """
    The pixels of observations. GRAY_OF_RGB pools colours and makes the result gray; RAM has no pixels.
    """

    NONE = 0

    GRAY = 1

    RGB = 2

    GRAY_OF_RGB = 3

    RAM = 4

class EndFrames(enum.Enum):
    """The frames that are observed when an episode ends inside a skip."""

    LAST = 0

    GYMNASIUM = 1

    BASELINES = 2

    ENVPOOL = 3

class Padding(enum.Enum):
    """The content of a new stack: zeros, or the first frame of the episode."""

    ZERO = 0

    RESET = 1

class Autoreset(enum.Enum):
    """The modes of gymnasium.vector.AutoresetMode."""

    NEXT_STEP = 0

    SAME_STEP = 1

    DISABLED = 2

class EpisodeSettings:
    """How episodes begin, are played, and end."""

    def __init__(self) -> None: ...
    @property
    def players(self) -> int: ...
    @players.setter
    def players(self, arg: int, /) -> None: ...
    @property
    def repeat_action_probability(self) -> float: ...
    @repeat_action_probability.setter
    def repeat_action_probability(self, arg: float, /) -> None: ...
    @property
    def seeding(self) -> Seeding: ...
    @seeding.setter
    def seeding(self, arg: Seeding, /) -> None: ...
    @property
    def frameskip(self) -> tuple[int, int]: ...
    @frameskip.setter
    def frameskip(self, arg: tuple[int, int], /) -> None: ...
    @property
    def noops(self) -> tuple[int, int]: ...
    @noops.setter
    def noops(self, arg: tuple[int, int], /) -> None: ...
    @property
    def fire(self) -> FirePress: ...
    @fire.setter
    def fire(self, arg: FirePress, /) -> None: ...
    @property
    def fire_counts(self) -> bool: ...
    @fire_counts.setter
    def fire_counts(self, arg: bool, /) -> None: ...
    @property
    def third_action(self) -> bool: ...
    @third_action.setter
    def third_action(self, arg: bool, /) -> None: ...
    @property
    def fire_unit(self) -> Unit: ...
    @fire_unit.setter
    def fire_unit(self, arg: Unit, /) -> None: ...
    @property
    def fire_again(self) -> bool: ...
    @fire_again.setter
    def fire_again(self, arg: bool, /) -> None: ...
    @property
    def episodic_life(self) -> bool: ...
    @episodic_life.setter
    def episodic_life(self, arg: bool, /) -> None: ...
    @property
    def lives_unit(self) -> Unit: ...
    @lives_unit.setter
    def lives_unit(self, arg: Unit, /) -> None: ...
    @property
    def on_reset(self) -> OnReset: ...
    @on_reset.setter
    def on_reset(self, arg: OnReset, /) -> None: ...
    @property
    def last_life(self) -> bool: ...
    @last_life.setter
    def last_life(self, arg: bool, /) -> None: ...
    @property
    def seamless_lives(self) -> bool: ...
    @seamless_lives.setter
    def seamless_lives(self, arg: bool, /) -> None: ...
    @property
    def life_loss_info(self) -> bool: ...
    @life_loss_info.setter
    def life_loss_info(self, arg: bool, /) -> None: ...
    @property
    def max_frames(self) -> int | None: ...
    @max_frames.setter
    def max_frames(self, arg: int | None, /) -> None: ...
    @property
    def max_episode_steps(self) -> int | None: ...
    @max_episode_steps.setter
    def max_episode_steps(self, arg: int | None, /) -> None: ...
    @property
    def max_num_frames_per_episode(self) -> int | None: ...
    @max_num_frames_per_episode.setter
    def max_num_frames_per_episode(self, arg: int | None, /) -> None: ...
    @property
    def reward_clipping(self) -> bool: ...
    @reward_clipping.setter
    def reward_clipping(self, arg: bool, /) -> None: ...
    @property
    def acts_after_end(self) -> bool: ...
    @acts_after_end.setter
    def acts_after_end(self, arg: bool, /) -> None: ...

class ObservationSettings:
    """How frames are pooled, resized and stacked."""

    def __init__(self) -> None: ...
    @property
    def pixels(self) -> PixelFormat: ...
    @pixels.setter
    def pixels(self, arg: PixelFormat, /) -> None: ...
    @property
    def img_height(self) -> int: ...
    @img_height.setter
    def img_height(self, arg: int, /) -> None: ...
    @property
    def img_width(self) -> int: ...
    @img_width.setter
    def img_width(self, arg: int, /) -> None: ...
    @property
    def stack_num(self) -> int: ...
    @stack_num.setter
    def stack_num(self, arg: int, /) -> None: ...
    @property
    def maxpool(self) -> bool: ...
    @maxpool.setter
    def maxpool(self, arg: bool, /) -> None: ...
    @property
    def end_frames(self) -> EndFrames: ...
    @end_frames.setter
    def end_frames(self, arg: EndFrames, /) -> None: ...
    @property
    def padding(self) -> Padding: ...
    @padding.setter
    def padding(self, arg: Padding, /) -> None: ...

class VectorSettings:
    """How many results make a batch, and which threads work on them."""

    def __init__(self) -> None: ...
    @property
    def batch_size(self) -> int: ...
    @batch_size.setter
    def batch_size(self, arg: int, /) -> None: ...
    @property
    def threads(self) -> int: ...
    @threads.setter
    def threads(self, arg: int, /) -> None: ...
    @property
    def first_core(self) -> int: ...
    @first_core.setter
    def first_core(self, arg: int, /) -> None: ...
    @property
    def autoreset(self) -> Autoreset: ...
    @autoreset.setter
    def autoreset(self, arg: Autoreset, /) -> None: ...

class LaneSpec:
    """
    The differences between the lanes of a vector. `seed` is nine words: one for the emulator, and eight for
    the generator of episodes.
    """

    def __init__(self) -> None: ...
    @property
    def game(self) -> Game: ...
    @game.setter
    def game(self, arg: Game, /) -> None: ...
    @property
    def reward(self) -> RewardFormula: ...
    @reward.setter
    def reward(self, arg: RewardFormula, /) -> None: ...
    @property
    def actions(self) -> list[int]: ...
    @actions.setter
    def actions(self, arg: Sequence[int], /) -> None: ...
    @property
    def action_set(self) -> list[int]: ...
    @action_set.setter
    def action_set(self, arg: Sequence[int], /) -> None: ...
    @property
    def mode(self) -> int | None: ...
    @mode.setter
    def mode(self, arg: int | None, /) -> None: ...
    @property
    def difficulty(self) -> int | None: ...
    @difficulty.setter
    def difficulty(self, arg: int | None, /) -> None: ...
    @property
    def seed(self) -> list[int]: ...
    @seed.setter
    def seed(self, arg: Sequence[int], /) -> None: ...

class RamOf(enum.Enum):
    """
    The present RAM, the RAM of the last result, or the RAM of the result before a reset in the
    last step.
    """

    NOW = 0

    RESULT = 1

    FINAL = 2

class Batch:
    """
    Arrays for the results of a batch. Threads write to them between start and receive.
    """

    def __init__(
        self,
        engine: VectorEngine,
        pixels: numpy.typing.NDArray[numpy.uint8] | None,
        ram: numpy.typing.NDArray[numpy.uint8] | None,
    ) -> None:
        """
        `pixels` and `ram` are the arrays for observations; None if observations have no such part.
        """

    @property
    def arrays(self) -> dict[str, numpy.typing.NDArray[Any]]:
        """
        The other arrays by their names (vector/batch.def): (rows,), or (rows, players) if each
        player has a value. Final pixels and RAM are (rows, bytes).
        """

    def aimed_at(
        self, pixels: numpy.typing.NDArray[numpy.uint8] | None, ram: numpy.typing.NDArray[numpy.uint8] | None
    ) -> Batch:
        """
        A batch with other arrays of observations, which shares the other arrays.
        """

class MemberSnapshot:
    """The state of a lane in memory. It can be pickled."""

    def __getstate__(self) -> tuple[bytes, int]: ...
    def __setstate__(self, arg: tuple[bytes, int], /) -> None: ...

class Loan:
    """A share in an array's memory, for `numpy.ndarray(buffer=)`."""

class ArrayLender:
    """Lends the memory of a uint8 array, without a copy."""

    def __init__(self, array: numpy.typing.NDArray[numpy.uint8]) -> None: ...
    def lend(self) -> Loan: ...
    @property
    def lent(self) -> bool:
        """
        Whether a loan exists: an array made from it, or a view or a tensor of such an array.
        """

class CallLock:
    """
    The lock of an object in Python, for `with`. Its thread may enter again. RuntimeError in a forked
    process.
    """

    def __init__(self, object: str) -> None: ...
    def __enter__(self) -> None: ...
    def __exit__(self, type: object | None, value: object | None, traceback: object | None) -> None: ...

class VectorEngine:
    """
    Environments played by a pool of threads. Use it through atari.AtariVectorEnv.
    """

    def __init__(
        self,
        lanes: Sequence[LaneSpec],
        episode: EpisodeSettings,
        observation: ObservationSettings,
        settings: VectorSettings,
    ) -> None: ...
    def start(
        self,
        actions: numpy.typing.NDArray[numpy.int64],
        strengths: numpy.typing.NDArray[numpy.float32] | None,
        batch: Batch | None,
        environments: numpy.typing.NDArray[numpy.int64] | None = None,
    ) -> None:
        """
        Begin a step of the environments of the last batch. If `batch` has rows for all environments, the
        results go there. `environments` are stepped, in the order of the actions. They may be some of all;
        then the rows of the others show their last results again.
        """

    def reset(
        self,
        mask: numpy.typing.NDArray[numpy.bool],
        seeded: numpy.typing.NDArray[numpy.bool],
        seeds: numpy.typing.NDArray[numpy.uint32],
        batch: Batch | None,
        new_games: bool = False,
    ) -> None:
        """
        Begin a reset of the environments in `mask`; `seeds` has nine words for each, as in `LaneSpec`. With
        `new_games`, no environment continues its game after a lost life.
        """

    def receive(self, batch: Batch) -> bool:
        """
        Wait for a batch of results; returns whether an episode or a game ended in it.
        """

    @property
    def sent(self) -> bool:
        """Whether a batch has been sent and not received."""

    def snapshot(self, environments: Sequence[int]) -> list[MemberSnapshot]: ...
    def restore(self, environments: Sequence[int], states: Sequence[MemberSnapshot]) -> None: ...
    def save(self, environment: int) -> bytes:
        """The state of one environment as bytes."""

    def save_emulator(self, environment: int) -> bytes:
        """The state of one environment's emulator as bytes, for Emulator.load."""

    def load(self, environment: int, state: bytes) -> None: ...
    def screen_rgb(self, environment: int) -> numpy.typing.NDArray[numpy.uint8]: ...
    def redraw(self, environment: int) -> numpy.typing.NDArray[numpy.uint8]: ...
    def ram(self, environment: int) -> bytes: ...
    def copy_rams(
        self, environments: numpy.typing.NDArray[numpy.int64], out: numpy.typing.NDArray[numpy.uint8], of: RamOf
    ) -> None:
        """Copy the RAM of environments to the rows of `out`."""

    def evaluate_labels(
        self,
        labels: Labels,
        environments: numpy.typing.NDArray[numpy.int32],
        values: numpy.typing.NDArray[numpy.int32],
        visible: numpy.typing.NDArray[numpy.bool],
        of: RamOf,
    ) -> None:
        """
        Copy RAM like `copy_rams`, then call `labels.evaluate` with the copies.
        """

    def set_ram(self, environment: int, index: int, value: int) -> None: ...
    def add_write(self, environment: int, write: Write, now: bool = False) -> None:
        """Call Emulator.add_write of an environment."""

    def remove_write(self, environment: int, write: Write) -> None: ...
    def numbers(self, environment: int) -> list[int]:
        """Frame number, episode frame number, and the lives of each player."""

    def mode(self, environment: int) -> int: ...
    def difficulty(self, environment: int) -> int: ...
    def set_mode(self, environment: int, mode: int) -> None: ...
    def set_difficulty(self, environment: int, difficulty: int) -> None: ...

class ObservationStack:
    """
    The pooled, resized and stacked frames that an agent observes, equal to those of a lane of `VectorEngine`.
    With PixelFormat.RAM it stacks the RAM.

    A frame is a core, or a C-contiguous uint8 array of palette indices, (rows, 160). A core's frame is
    rendered only if an image needs it. Raises ValueError if a size is not supported or a core has other rows
    or another TV format, TypeError for another frame. RAM comes from a core, or is an array (128,).
    """

    def __init__(self, settings: ObservationSettings, rows: int, format: str) -> None: ...
    def begin(self, frame: object, new_stack: bool = True) -> None:
        """
        Begin an episode with the present frame; `new_stack` drops the images before it.
        """

    def repeat(self, new_stack: bool = False) -> None:
        """Add the last image again."""

    def frame_played(self, frame: object, left: int, ended: bool) -> None:
        """
        A frame of a skip was played, and `left` remain; `ended`: the episode ended with this frame. The call
        with `left` 1 is required; a core must then play exactly one frame before `skip_ended`.
        """

    def skip_ended(self, frame: object, left: int, ended: bool) -> None:
        """Add the image of a skip, `left` frames before its end."""

    def observation(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        A new array, (stack_num, img_height, img_width), with a last axis of 3 for colours; for RAM (stack_num,
        128). The oldest image is the first.
        """

    def save(self) -> bytes:
        """The images, and the frames that the next image may need, as bytes."""

    def load(self, state: bytes) -> None:
        """
        Continue from `save` of a stack with the same settings; ValueError if the bytes have another length.
        """

    def __getstate__(self) -> tuple[int, int, int, int, bool, int, int, int, str, bytes]: ...
    def __setstate__(self, arg: tuple[int, int, int, int, bool, int, int, int, str, bytes], /) -> None: ...

class XlaPort:
    """
    Access to a vector engine for functions compiled by JAX, as long as this
    object exists.
    """

    def __init__(self, engine: VectorEngine, pixels: bool, ram: bool) -> None: ...
    def results(self) -> list[tuple[str, str, tuple[int, ...]]]:
        """
        Name, dtype and shape of each result of a compiled function, in their order.
        """

    @property
    def handle(self) -> bytes:
        """Eight bytes by which handlers find the engine."""

def xla_targets() -> dict[str, object]:
    """The handlers by their names, for `jax.ffi.register_ffi_target`."""

class ReplayGeometry:
    """The sizes of a replay memory. ValueError if a number is out of range."""

    def __init__(
        self,
        *,
        lanes: int,
        rows: int,
        margin: int,
        finals: int,
        parts: Sequence[tuple[int, int, int]],
        action_bytes: int,
        autoreset: int,
        repeat_first: bool,
        exponent: float | None,
        saved: bool,
        packed_bytes: int | None,
    ) -> None:
        """
        `rows` and `margin` are steps of each lane. Each of `parts` has the bytes of a frame, the bytes from a
        pixel to the one below, and the most frames of an observation. `autoreset` is 0 NEXT_STEP, 1
        SAME_STEP, 2 DISABLED. With `packed_bytes`, the compressed frames get this number of bytes.
        """

    @staticmethod
    def least_packed_bytes(geometry: ReplayGeometry) -> int:
        """The least `packed_bytes` with which a memory of these sizes works."""

    @property
    def block_bytes(self) -> int:
        """Bytes of the block that holds a memory of these sizes."""

    @property
    def packed_offset(self) -> int:
        """
        The offset of the compressed frames, which are written when they are needed.
        """

class ReplayMemory:
    """
    The frames and steps of a replay memory. Use it through atari.learning.
    """

    def __init__(self, geometry: ReplayGeometry, block: numpy.typing.NDArray[numpy.uint8]) -> None:
        """
        `block` has `geometry.block_bytes` bytes: zeros, or a memory of this geometry; then call `load`.
        """

    def next_place(self) -> int:
        """
        The place of the next row's frames, in 0 .. places-1. BufferError if a save is due.
        """

    def places(self, part: int) -> tuple[int, int]:
        """
        The offset of a part's frames in the block, and the number of rows that have a place.
        """

    def seed(self, seed: int) -> None: ...
    def reset(
        self, mask: numpy.typing.NDArray[numpy.bool] | None, frames: Sequence[numpy.typing.NDArray[numpy.uint8]]
    ) -> None:
        """
        Begin episodes in all lanes with the next row's frames, or in the lanes of `mask` with `frames`.
        """

    def add(
        self,
        actions: numpy.typing.NDArray[numpy.uint8],
        rewards: numpy.typing.NDArray[numpy.float32],
        terminated: numpy.typing.NDArray[numpy.bool],
        truncated: numpy.typing.NDArray[numpy.bool],
        finals: Sequence[numpy.typing.NDArray[numpy.uint8]],
    ) -> None:
        """
        Complete a step of all lanes, after the next row's frames were written. `actions` are bytes.
        """

    def try_add(self, actions: object, rewards: object, terminated: object, truncated: object) -> bool:
        """
        Call `add` if the arrays are int64, int32 or float64, and bool with one axis; returns whether they are.
        """

    def observe(self, stacks: Sequence[int], to: Sequence[numpy.typing.NDArray[numpy.uint8]]) -> None: ...
    def count(self, reach: int) -> int: ...
    def sample(self, target: ReplayTarget, reach: int, discount: float, beta: float | None, threads: int) -> None: ...
    def update_priorities(
        self, indices: numpy.typing.NDArray[numpy.int64], priorities: numpy.typing.NDArray[numpy.float64]
    ) -> None: ...
    @property
    def must_save(self) -> bool:
        """
        Whether the next `add` or `reset` may raise BufferError, because it would overwrite the last saved state.
        """

    def begin_save(self) -> None:
        """
        The first of the three phases of a save, which makes the present state the one that `load` finds. After
        each, the block must reach the disk. `end_save` counts the save.
        """

    def write_save(self) -> None: ...
    def complete_save(self) -> None: ...
    def end_save(self) -> None: ...
    def save_copy(self, block: numpy.typing.NDArray[numpy.uint8]) -> None:
        """Save the present state in a copy of the block."""

    def load(self, verify: bool, save: int | None) -> None:
        """
        Read the last saved state, or the state of the save with this number; ValueError says what is damaged.
        `verify` reads all frames. Then the block must reach the disk, and `resume` ends the work.
        """

    def resume(self) -> None: ...
    @property
    def numbers(self) -> tuple[bool, int, int, int]:
        """
        Whether there was a reset, the steps ever added, the saves, and the bytes in use.
        """

class ReplayTarget:
    """The arrays of a batch. `sample` writes to them."""

    def __init__(
        self,
        memory: ReplayMemory,
        count: int,
        length: int,
        stacks: Sequence[int],
        observations: Sequence[numpy.typing.NDArray[numpy.uint8]],
        next_observations: Sequence[numpy.typing.NDArray[numpy.uint8]],
        actions: numpy.typing.NDArray[numpy.uint8],
        rewards: numpy.typing.NDArray[numpy.float32],
        terminations: numpy.typing.NDArray[numpy.bool],
        truncations: numpy.typing.NDArray[numpy.bool],
        indices: numpy.typing.NDArray[numpy.int64],
        discounts: numpy.typing.NDArray[numpy.float32] | None,
        weights: numpy.typing.NDArray[numpy.float32] | None,
        mask: numpy.typing.NDArray[numpy.bool] | None,
    ) -> None:
        """
        `length` is the length of sequences, which have a mask; for transitions it is 0. Transitions of one
        step may have no `next_observations`; then each observation has one more frame, the newest frame of
        the next one.
        """

class Causes:
    """The effects of each byte of RAM; see emulator/lab/causes.hpp."""

    def __init__(self, *, game: Game, values: int, frames: int, threads: int, seed: int) -> None: ...
    def explore(self, states: list[State], actions: numpy.typing.NDArray[numpy.uint8], first: int) -> None:
        """
        Count the effects of changes of each byte from these states, with the actions of each state's frames.
        """

    def counts(self) -> numpy.typing.NDArray[numpy.uint32]:
        """The fields of `ByteCauses`, a row for each byte."""

    def effects(self) -> numpy.typing.NDArray[numpy.int32]:
        """The fields of `ForkEffect`, a row for each fork with an effect."""

    def pixels(self) -> numpy.typing.NDArray[numpy.uint16]:
        """
        (128, height, 160): the number of forks of a byte that changed a pixel.
        """

    @property
    def frames_played(self) -> int: ...

class Labels:
    """Labels of RAM bytes, compiled. Use it through atari.lab."""

    def __init__(self, labels: Sequence[tuple[int, int, bool, Sequence[int], Sequence[int]]]) -> None:
        """
        `labels` are tuples: index 0..127, mask 0..255, whether the byte is binary-coded decimal, and the
        programs for the value and the visibility, which may be empty. Variable 0 is the byte, variable 1 the
        result.
        """

    def __len__(self) -> int: ...
    def evaluate(
        self,
        ram: numpy.typing.NDArray[numpy.uint8],
        values: numpy.typing.NDArray[numpy.int32],
        visible: numpy.typing.NDArray[numpy.bool],
    ) -> None:
        """
        Fill `values` and `visible`, (labels, rows), from `ram`, (rows, 128). Values that are not visible are 0.
        """

    def byte_of(self, label: int, ram: numpy.typing.NDArray[numpy.uint8], value: int) -> int:
        """The byte that gives a label this value in this RAM, or -1."""

    def possible_values(self, label: int, ram: numpy.typing.NDArray[numpy.uint8]) -> list[int]:
        """
        The values that a write can give a label in this RAM, in ascending order.
        """
