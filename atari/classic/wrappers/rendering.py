"""Wrappers that render by themselves."""

from typing import Any

from atari.classic.core import Env, Step, Wrapper
from atari.classic.viewer import Viewer


class HumanRendering(Wrapper):
    """Shows the images of an environment that renders "rgb_array" in a window, after each reset and step."""

    render_mode = "human"

    def __init__(self, env: Env) -> None:
        super().__init__(env)
        self.screen_size: tuple[int, int] | None = None
        self.window: Viewer | None = None
        self.clock = None

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        self._render_frame()
        return observation

    def _step(self, action: Any) -> Step:
        result = self.env.step(action)
        self._render_frame()
        return result

    def _render(self, *args: Any, **options: Any) -> Any:
        return self.env.render(*args, **options) if args or options else None

    def _render_frame(self) -> None:
        image = self.env.render(mode="rgb_array")
        if self.window is None:
            self.window = Viewer(str(self.env), self.metadata.get("video.frames_per_second", 30))
            self.screen_size = image.shape[1::-1]
        self.window.imshow(image)

    def _close(self) -> None:
        if self.window is not None:
            self.window.close()
        self.env.close()


class RenderCollection(Wrapper):
    """`render` returns the images of all steps since the last `render`.

    Args:
        env: an environment that renders "rgb_array".
        pop_frames: False keeps the images for the next `render`.
        reset_clean: a reset removes the images before it.
    """

    render_mode = "rgb_array_list"

    def __init__(self, env: Env, pop_frames: bool = True, reset_clean: bool = True) -> None:
        super().__init__(env)
        self.frame_list: list[Any] = []
        self.pop_frames = pop_frames
        self.reset_clean = reset_clean

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        if self.reset_clean:
            self.frame_list = []
        self.frame_list.append(self.env.render(mode="rgb_array"))
        return observation

    def _step(self, action: Any) -> Step:
        result = self.env.step(action)
        self.frame_list.append(self.env.render(mode="rgb_array"))
        return result

    def _render(self, *args: Any, **options: Any) -> list[Any]:
        frames = self.frame_list
        if self.pop_frames:
            self.frame_list = []
        return frames
