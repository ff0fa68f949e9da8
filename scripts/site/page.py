"""`Page`: a file of the site that is made when the site is built."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Page:
    """A file of the site that is in no folder of the repository.

    Attributes:
        path: its place if it were in docs/, for example "games/pong.md" or "games/pong.png". Markdown becomes a page.
        content: text, the bytes of a picture or video, or the path of a file that has them.
        title: the title of the page in the navigation; "" leaves it out there.
    """

    path: str
    content: str | bytes | Path
    title: str = ""
