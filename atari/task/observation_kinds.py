"""`KINDS`: the content of observations, a row for each value of the field `obs_type`.

Other modules read the row of a task, `Task.kind`, and do not compare the names.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

ObsType = Literal["rgb", "grayscale", "ram", "dict", "rgb_dict"]
IN_WORDS = "rgb, grayscale, ram (128 bytes), dict (gray image and RAM) or rgb_dict"


@dataclass(frozen=True)
class Kind:
    """The content of observations: an image, the RAM, or a dict of both.

    Attributes:
        image: the observation type of the image alone; None if there is no image. `stack_num` then stacks the RAM.
        pixels: the pixels in words; in capitals, a member of `_emulator.PixelFormat`.
        method: the method of a core that returns the observation; "" if wrappers make it.
        colours: the axes that follow the rows and columns of the image.
        ram: whether the RAM is shown.
    """

    image: str | None
    pixels: str
    method: str
    colours: tuple[int, ...] = ()
    ram: bool = False

    @property
    def is_dict(self) -> bool:
        """Whether observations are dicts of image and RAM."""
        return self.ram and self.image is not None

    @property
    def is_gray(self) -> bool:
        """Whether a pixel of the image is one value."""
        return self.image is not None and not self.colours


_RGB, _GRAY = Kind("rgb", "RGB", "screen_rgb", (3,)), Kind("grayscale", "gray", "screen_grayscale")

KINDS: Mapping[str, Kind] = {
    "rgb": _RGB,
    "grayscale": _GRAY,
    "ram": Kind(None, "RAM", "ram", ram=True),
    "dict": replace(_GRAY, method="", ram=True),
    "rgb_dict": replace(_RGB, method="", ram=True),
}


def kind_of(obs_type: Any) -> Kind:
    """The row of an observation type. A value that the field's check refuses has the row of "rgb"."""
    return next((kind for name, kind in KINDS.items() if name == obs_type), _RGB)


def with_image(*, gray: bool, ram: bool) -> str:
    """The observation type of a gray or RGB image, alone or with the RAM."""
    return next(name for name, kind in KINDS.items() if kind.image and (kind.is_gray, kind.ram) == (gray, ram))
