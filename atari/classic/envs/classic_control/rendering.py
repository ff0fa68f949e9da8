"""`SimpleImageViewer`: a window for images, of `gym.envs.classic_control.rendering`.

Gym's other viewer, `Viewer`, drew geometry by OpenGL; it is not provided.
"""

from typing import Any

from atari.classic.viewer import Viewer as Window


class SimpleImageViewer(Window):
    """A window that shows images; `display` and `maxwidth` have no effect.

    Example:
        >>> import numpy, atari.classic as gym
        >>> viewer = gym.envs.classic_control.rendering.SimpleImageViewer()
        >>> viewer.imshow(numpy.zeros((210, 160, 3), numpy.uint8))
        >>> viewer.close()
    """

    def __init__(self, display: Any = None, maxwidth: int = 500) -> None:
        super().__init__("SimpleImageViewer", frames_per_second=0)
        self.display = display
        self.maxwidth = maxwidth

    def imshow(self, arr: Any) -> None:
        """Show one image, (rows, columns, 3) uint8."""
        super().imshow(arr)


def __getattr__(name: str) -> Any:
    if name == "Viewer":
        raise AttributeError(
            "rendering.Viewer drew by OpenGL and is not provided; draw an image and show it by "
            "rendering.SimpleImageViewer().imshow(image)"
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
