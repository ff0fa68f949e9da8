"""
The native emulator, bound. Use it through atari.cores.NativeCore, which checks options and finds ROMs.
"""

from collections.abc import Sequence
from typing import Any

import numpy
import numpy.typing

END: int = 39

class Game:
    """
    A game, compiled: cartridge, console, rules. Immutable; emulators share it.
    """

    @property
    def cartridge_type(self) -> str:
        """The bank switching that was given or recognised, for example "F8"."""

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

class State:
    """A state in memory, as `Emulator.clone_state` returned it."""

class Emulator:
    """
    A running game. The lock of the interpreter is released while it emulates.
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
    ) -> None:
        """
        `plain`: by the plain interpreter and TIA, which are slower and give the same.
        """

    def seed(self, seed: int) -> None: ...
    def reset(self) -> None: ...
    def act(self, action: int, strength: float = 1.0) -> int: ...
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
    def save(self) -> bytes:
        """The whole state as bytes, of the layout of this build."""

    def load(self, state: bytes) -> None:
        """Continue from `save`; ValueError if the bytes cannot be a state."""

    def clone_state(self, include_rng: bool = False) -> State:
        """
        The whole state in memory; `include_rng` says whether restoring it takes the generator along.
        """

    def restore_state(self, state: State) -> None:
        """
        Continue from a state of `clone_state`; ValueError if it is of another game or core.
        """

    def close(self) -> None: ...

class AreaResize:
    """
    Scales a gray picture, (rows, 160), down to (height, width) as OpenCV's INTER_AREA does, to the byte.

    Raises ValueError if the size is not served: larger than the picture, narrower than 11, or
    dividing the picture's in both directions.
    """

    def __init__(self, rows: int, height: int, width: int) -> None: ...
    def __call__(self, picture: numpy.typing.NDArray[numpy.uint8], out: numpy.typing.NDArray[numpy.uint8]) -> None: ...
    def __getstate__(self) -> tuple[int, int, int]: ...
    def __setstate__(self, arg: tuple[int, int, int], /) -> None: ...

class Moment:
    """A state in memory, as `Console.remember` returned it."""

class Console:
    """
    A bare console, driven by hand: for tests and for looking inside.

    Made as at power-on, after one reset; no frame has begun. `cartridge` names the type of bank
    switching, "" recognises it; the other arguments are those of a game's screen and controllers.
    `plain`: by the plain interpreter and TIA; if not, `run_frame` runs frames fast, and `translated`,
    where that is possible, by machine code made of the program.
    Raises ValueError if the image is of no supported type.
    """

    def __init__(
        self,
        image: bytes,
        cartridge: str = "",
        *,
        first_line: int = 34,
        height: int = 210,
        pal: bool = False,
        hmove_blanks: bool = True,
        paddles: tuple[bool, bool] = (False, False),
        swap_ports: bool = False,
        swap_paddles: bool = False,
        plain: bool = True,
        translated: bool = True,
    ) -> None: ...
    def reset(self) -> None:
        """The reset of all chips, as a game is reset. RAM survives."""

    def read(self, address: int) -> int:
        """A read on the bus, at the present cycle; an int within 0..255."""

    def write(self, address: int, value: int) -> None:
        """A write on the bus, at the present cycle."""

    def step(self) -> None:
        """
        Run one instruction; nothing once an illegal opcode has stopped the processor.
        """

    def start_frame(self) -> None:
        """Begin a frame: cycles count from 0 again, lines keep their phase."""

    def run_frame(self) -> None:
        """Run until the frame ends, for at most 25000 instructions."""

    @property
    def cycles(self) -> int:
        """
        Processor cycles since the frame began; the chips see what is set here as time.
        """

    @cycles.setter
    def cycles(self, arg: int, /) -> None: ...
    @property
    def scan_lines(self) -> int:
        """Lines since the frame began."""

    @property
    def registers(self, /) -> dict[str, int]:
        """
        Of the processor: a, x, y, sp, pc, and the flags n, v, d, i, z, c as bools.
        """

    def set_registers(self, **changes: int) -> None:
        """Change some of `registers`, given by name."""

    @property
    def ram(self) -> bytes:
        """The 128 bytes of RAM."""

    @ram.setter
    def ram(self, arg: bytes, /) -> None: ...
    @property
    def cartridge_ram(self) -> bytes:
        """The cartridge's own RAM, empty if it has none."""

    @property
    def translated(self) -> bool:
        """Whether there is machine code of the program."""

    @property
    def cartridge_type(self) -> str: ...
    @property
    def positions(self, /) -> list[int]:
        """
        Of player 0, player 1, missile 0, missile 1 and ball: five columns within 0..159.
        """

    @positions.setter
    def positions(self, arg: Sequence[int], /) -> None: ...
    def picture(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        The current frame's picture up to the latest access of the TIA: uint8 (height, 160), palette indices.
        """

    def make_samples(self) -> numpy.typing.NDArray[numpy.uint8]:
        """The next 512 samples of sound: uint8 (512,), unsigned around 128."""

    def set_inputs(
        self,
        *,
        switches: int = 63,
        sticks: Sequence[int] = [0, 0],
        fire: Sequence[bool] = [False, False],
        resistances: Sequence[int] = [0, 0, 0, 0],
        paddle_fire: Sequence[bool] = [False, False, False, False],
    ) -> None:
        """
        What is pressed: SWCHB, both sticks (bits 0-3: up, down, left, right), fire, paddles. Default: nothing.
        """

    def state(self) -> dict[str, Any]:
        """
        All chips' registers and latches, by name, as nested dicts. For looking, not for saving.
        """

    def save(self) -> bytes:
        """The whole state as bytes."""

    def load(self, state: bytes) -> None:
        """Continue from `save`; ValueError if the bytes cannot be a state."""

    def remember(self) -> Moment:
        """The whole state in memory, with what is still to be drawn."""

    def go_back(self, moment: Moment) -> None:
        """Continue from `remember` of this console."""

def ways() -> int:
    """
    In how many ways this processor can do what follows, by instructions that not every one has. Way 0 is the
    portable one, the last the fastest, which None stands for. Results are the same.
    """

def paint(
    layers: Sequence[numpy.typing.NDArray[numpy.uint8]], colours: Sequence[int], first: int, last: int, way: int
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    A row of 160 zeros in which pixels first .. last-1 have been painted: those of the three layers, (160,) each,
    in the first three colours, the others in the fourth.
    """

def to_rgb(
    picture: numpy.typing.NDArray[numpy.uint8], format: str, way: int | None = None
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    A picture of palette indices, (rows, 160), in the colours of a TV format.
    """

def same_state(first: Console, second: Console, complete: bool) -> bool:
    """
    Whether two consoles are in the same state to the byte. Unless this is `complete`, pictures and collision
    latches are left out; a console that runs frames fast then goes on leaving them for later.
    """

def pool_gray(
    early: numpy.typing.NDArray[numpy.uint8],
    late: numpy.typing.NDArray[numpy.uint8],
    table: numpy.typing.NDArray[numpy.uint8],
    way: int | None = None,
) -> tuple[numpy.typing.NDArray[numpy.uint8], list[int]]:
    """
    The brighter of two pictures, (rows, 160) palette indices, by a table of 256 grays, or what a table of 65,536
    has for early * 256 + late; and for each row bit k if columns 8k .. 8k+7 differ from the row above.
    """

def resize_area(
    picture: numpy.typing.NDArray[numpy.uint8],
    height: int,
    width: int,
    changes: Sequence[int] | None = None,
    way: int | None = None,
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    A gray picture, (rows, 160), scaled down as by OpenCV's INTER_AREA. `changes` as from `pool_gray`.
    Raises ValueError if the size is not served.
    """

class Batch:
    """
    Arrays for the results of a batch. Threads write to them between start and receive.
    """

    def __init__(
        self,
        vector: Vector,
        *,
        pixels: numpy.typing.NDArray[numpy.uint8] | None,
        ram: numpy.typing.NDArray[numpy.uint8] | None,
        final_pixels: numpy.typing.NDArray[numpy.uint8] | None,
        final_ram: numpy.typing.NDArray[numpy.uint8] | None,
        numbers: numpy.typing.NDArray[numpy.int32],
        flags: numpy.typing.NDArray[numpy.bool],
    ) -> None:
        """
        `numbers` is int32 (8, rows): reward, environment, lives, frame and episode frame number, and the last three
        of the final observation; `flags` bool (3, rows): terminated, truncated, has a final observation.
        """

class MemberState:
    """The state of an environment of a vector, in memory. It can be pickled."""

    def __getstate__(self) -> tuple[bytes, int]: ...
    def __setstate__(self, arg: tuple[bytes, int], /) -> None: ...

class Vector:
    """
    Environments played by a pool of threads. Use it through atari.AtariVectorEnv.
    """

    def __init__(
        self,
        *,
        games: Sequence[Game],
        actions: Sequence[Sequence[int]],
        action_sets: Sequence[Sequence[int]],
        modes: Sequence[int | None],
        difficulties: Sequence[int | None],
        seeds: numpy.typing.NDArray[numpy.uint32],
        pairs: Sequence[bytes],
        repeat_action_probability: float,
        episode_limit: int,
        protocol: str,
        frame_skip: tuple[int, int],
        noops: tuple[int, int],
        fire_counts: bool,
        fire: str,
        episodic_life: bool,
        life_loss_info: bool,
        on_reset: str,
        last_life: bool,
        seamless_lives: bool,
        clip_reward: bool,
        max_frames: int,
        pixels: str,
        height: int,
        width: int,
        stack: int,
        max_pool: bool,
        end_frames: str,
        pads_zero: bool,
        batch_size: int,
        threads: int,
        first_core: int,
        autoreset: str,
    ) -> None:
        """
        `seeds` is (environments, 9): the emulator's, and eight words for the other generator.
        """

    def start(
        self,
        actions: numpy.typing.NDArray[numpy.int64],
        strengths: numpy.typing.NDArray[numpy.float32] | None,
        batch: Batch | None,
    ) -> None:
        """
        Begin a step of the environments of the last batch; the batch is where results go if it is of all of them.
        """

    def reset(
        self,
        mask: numpy.typing.NDArray[numpy.bool],
        seeded: numpy.typing.NDArray[numpy.bool],
        seeds: numpy.typing.NDArray[numpy.uint32],
        batch: Batch | None,
    ) -> None:
        """Begin a reset of the environments in `mask`; `seeds` as above."""

    def receive(self, batch: Batch) -> None:
        """Wait for a batch of results."""

    def snapshot(self, environments: Sequence[int]) -> list[MemberState]: ...
    def restore(self, environments: Sequence[int], states: Sequence[MemberState]) -> None: ...
    def fork(self, source: int, targets: Sequence[int]) -> None: ...
    def save(self, environment: int) -> bytes:
        """The state of one environment as bytes."""

    def load(self, environment: int, state: bytes) -> None: ...
    def screen_rgb(self, environment: int) -> numpy.typing.NDArray[numpy.uint8]: ...
    def ram(self, environment: int) -> bytes: ...
    def set_ram(self, environment: int, index: int, value: int) -> None: ...
    def numbers(self, environment: int) -> list[int]:
        """Lives, frame number, episode frame number."""

    def mode(self, environment: int) -> int: ...
    def difficulty(self, environment: int) -> int: ...
    def set_mode(self, environment: int, mode: int) -> None: ...
    def set_difficulty(self, environment: int, difficulty: int) -> None: ...
