"""Files of PyTorch with a checksum, which `torch.load` reads as any other: it is the comment of their zip archive."""

import hashlib
import io
import re
import struct
import zipfile
from pathlib import Path
from typing import Any

import torch

from atari.base.validation import check_file

_COMMENT = re.compile(rb"atari-envs sha256 ([0-9a-f]{64})\Z")
_LENGTH = len(b"atari-envs sha256 ") + 64


def sealed(value: Any, pickle_protocol: int = 2) -> bytes:
    """The file of a value, with a checksum of its bytes. PyTorch reads weights alone from protocol 2."""
    file = io.BytesIO()
    torch.save(value, file, pickle_protocol=pickle_protocol)
    body = file.getvalue()[:-2] + struct.pack("<H", _LENGTH)  # an archive ends with the length of its comment
    return body + b"atari-envs sha256 " + hashlib.sha256(body).hexdigest().encode()


def load_sealed(path: Path, *, weights_only: bool) -> Any:
    """The value of a file, on the CPU.

    Args:
        path: the file.
        weights_only: read tensors and containers of them alone. Otherwise the file's pickles are executed.

    Raises:
        FileNotFoundError, OSError: there is no such file, or it cannot be read.
        ValueError: the file is damaged.
    """
    check_file(path)
    data = path.read_bytes()
    found = _COMMENT.search(data[-_LENGTH:])
    if found is None:
        raise ValueError(f"{path} is damaged: its end with the checksum is missing")
    if hashlib.sha256(data[:-_LENGTH]).hexdigest().encode() != found[1]:
        raise ValueError(f"{path} is damaged: its checksum differs")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if any(member.compress_type != zipfile.ZIP_STORED for member in archive.infolist()):
                raise ValueError("it has compressed parts")
        return torch.load(io.BytesIO(data), map_location="cpu", weights_only=weights_only)
    except Exception as error:  # torch.load raises whatever a damaged file makes of its parsers
        raise ValueError(f"{path} is damaged: {error or type(error).__name__}") from None
