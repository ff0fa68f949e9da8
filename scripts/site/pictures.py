"""Arrays as PNG pictures and as silent videos."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import av
import numpy as np
import numpy.typing as npt

from atari.base.png import png as png_of

Image = npt.NDArray[np.uint8]


def png(image: Image, scale: int = 1) -> bytes:
    """A PNG file of an RGB (rows, columns, 3) or gray (rows, columns) image, each pixel `scale` by `scale`."""
    return png_of(image.repeat(scale, axis=0).repeat(scale, axis=1))


def strip(images: Iterable[Image], gap: int = 3, shade: int = 128) -> Image:
    """Gray images beside each other, with gaps of one shade."""
    columns: list[Image] = []
    for image in images:
        if columns:
            columns.append(np.full((len(image), gap), shade, np.uint8))
        columns.append(image)
    return np.concatenate(columns, axis=1)


def mosaic(images: Sequence[Image], columns: int) -> Image:
    """RGB images of one size in rows of `columns`, black after the last."""
    filled = [*images, *[np.zeros_like(images[0])] * (-len(images) % columns)]
    return np.concatenate(
        [np.concatenate(filled[row : row + columns], axis=1) for row in range(0, len(filled), columns)]
    )


def mp4(frames: Sequence[Image], rate: int, crf: int = 28) -> bytes:
    """A silent H.264 video of RGB frames, which a browser can show from its first bytes."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "video.mp4")
        with av.open(str(path), "w", options={"movflags": "faststart"}) as container:
            stream: Any = container.add_stream("libx264", rate=rate, options={"crf": str(crf), "preset": "fast"})
            stream.pix_fmt = "yuv420p"
            stream.height, stream.width = frames[0].shape[:2]
            for frame in frames:
                container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
            container.mux(stream.encode())
        return path.read_bytes()
