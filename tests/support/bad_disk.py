"""Disks that cannot be written: full ones, and those that fail at the n-th write, once or from then on.

A disk is described by a JSON table, so that another process uses it. `outside` is entered by the process that starts the
other one, `Disk.spoil` and `Disk.repair` are called in that one.
"""

import ctypes
import errno
import os
import random
import shutil
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

_SIZE = 64 << 20
_SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[4096];
static long before = -1;
static int number, ever;

void bad_disk(const char *in, long count, int error, int always) {
  snprintf(folder, sizeof folder, "%s/", in);
  number = error; ever = always; before = count;
}

__attribute__((constructor)) static void begin(void) {
  const char *in = getenv("BAD_DISK"), *count = getenv("BAD_DISK_COUNT"), *error = getenv("BAD_DISK_ERROR");
  if (in && count && error) bad_disk(in, atol(count), atoi(error), getenv("BAD_DISK_EVER") != NULL);
}

static int fails(int file) {
  char link[64], target[4096];
  if (before < 0) return 0;
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  ssize_t size = readlink(link, target, sizeof target - 1);
  if (size <= 0) return 0;
  target[size] = 0;
  if (strncmp(target, folder, strlen(folder))) return 0;
  if (before > 0) { before--; return 0; }
  if (!ever) before = -1;
  errno = number;
  return 1;
}

#define WRITES(name, result, parameters, arguments) \
  result name parameters { \
    static result (*real) parameters; \
    if (!real) real = (result (*) parameters)dlsym(RTLD_NEXT, #name); \
    return fails(file) ? -1 : real arguments; \
  }
WRITES(write, ssize_t, (int file, const void *data, size_t size), (file, data, size))
WRITES(pwrite, ssize_t, (int file, const void *data, size_t size, off_t at), (file, data, size, at))
WRITES(pwrite64, ssize_t, (int file, const void *data, size_t size, off64_t at), (file, data, size, at))
WRITES(writev, ssize_t, (int file, const struct iovec *data, int count), (file, data, count))
WRITES(pwritev, ssize_t, (int file, const struct iovec *data, int count, off_t at), (file, data, count, at))
WRITES(ftruncate, int, (int file, off_t size), (file, size))
WRITES(ftruncate64, int, (int file, off64_t size), (file, size))
WRITES(fsync, int, (int file), (file))
WRITES(fdatasync, int, (int file), (file))
"""


def kinds() -> dict[str, str]:
    """The kinds of disks, and why one cannot be had here; "" if it can."""
    mounts = (
        "" if os.geteuid() == 0 and sys.platform == "linux" and _can_mount() else "only root mounts a disk of memory"
    )
    compiler = "" if sys.platform == "linux" and shutil.which("cc") else "it takes Linux and a C compiler, cc"
    limits = "" if os.name == "posix" else "this system has no limit of a file's size"
    return {"full": mounts, "limited": limits, "failing": compiler, "taken": limits}


@cache
def _can_mount() -> bool:
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", folder], capture_output=True, check=False
        )
        if done.returncode == 0:
            subprocess.run(["umount", folder], check=True)
        return done.returncode == 0


@cache
def _shim() -> str:
    """The library that makes writes fail. It is made once for all processes of a user."""
    library = Path(tempfile.gettempdir(), f"bad-disk-{os.getuid()}-{zlib.crc32(_SHIM.encode())}.so")
    if not library.exists():
        own = library.with_suffix(f".{os.getpid()}")
        words = ["cc", "-shared", "-fPIC", "-O1", "-x", "c", "-", "-o", str(own), "-ldl"]
        subprocess.run(words, input=_SHIM.encode(), check=True)
        own.replace(library)
    return str(library)


def draw(source: random.Random, kind: str) -> dict[str, Any]:
    """A disk of a kind: its room in bytes and the number of its writes are small as often as they are large."""
    room = int(2 ** source.uniform(0, 22)) - 1
    return {
        "kind": kind,
        "room": room,
        "count": int(2 ** source.uniform(0, 9)) - 1,
        "error": source.choice((errno.ENOSPC, errno.EIO, errno.EDQUOT)),
        "ever": source.random() < 0.5,
        "taken": source.choice(("pipe", "folder", "link to a pipe")),
    }


@contextmanager
def outside(disk: dict[str, Any]) -> Iterator[tuple[Path, dict[str, str]]]:
    """The folder of a disk, and the environment of a process that uses it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve() / "disk"
        folder.mkdir()
        environment = dict(os.environ)
        if disk["kind"] == "failing":
            environment["LD_PRELOAD"] = _shim()
        if disk["kind"] == "full":
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={_SIZE}", "tmpfs", folder], check=True)
        try:
            yield folder, environment
        finally:
            if disk["kind"] == "full":
                subprocess.run(["umount", "-l", folder], check=True)


class Disk:
    """A disk, in the process that writes to it."""

    def __init__(self, table: dict[str, Any], folder: Path) -> None:
        self.table, self.folder, self.kind = table, folder, table["kind"]
        self._filler = folder / "filler"

    def spoil(self, target: Path) -> None:
        """From now on the disk cannot be written, or the name `target` is taken by something else than a file."""
        if self.kind == "full":
            free = shutil.disk_usage(self.folder).free - self.table["room"]
            with self._filler.open("wb", buffering=0) as file, suppress(OSError):
                while free > 0:
                    free -= file.write(bytes(min(free, 1 << 20)))
        elif self.kind == "limited":
            import resource

            _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
            resource.setrlimit(resource.RLIMIT_FSIZE, (self.table["room"], hard))
        elif self.kind == "failing":
            names = ("BAD_DISK", "BAD_DISK_COUNT", "BAD_DISK_ERROR", "BAD_DISK_EVER")
            values = (str(self.folder), str(self.table["count"]), str(self.table["error"]), "1")
            os.environ.update(list(zip(names, values, strict=True))[: 4 if self.table["ever"] else 3])
            self._call(os.fsencode(self.folder), self.table["count"], self.table["error"], self.table["ever"])
        elif self.table["taken"] == "folder":
            (target / "inside").mkdir(parents=True)
        elif self.table["taken"] == "pipe":
            os.mkfifo(target)
        else:
            os.mkfifo(self._filler)
            target.symlink_to(self._filler)

    def repair(self, target: Path) -> None:
        """The disk has room again, and the name is free."""
        if self.kind == "limited":
            import resource

            _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
            resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
        elif self.kind == "failing":
            for name in ("BAD_DISK", "BAD_DISK_COUNT", "BAD_DISK_ERROR", "BAD_DISK_EVER"):
                os.environ.pop(name, None)
            self._call(b"", -1, 0, False)
        elif self.kind == "taken":
            shutil.rmtree(target) if target.is_dir() else target.unlink(missing_ok=True)
        self._filler.unlink(missing_ok=True)

    def is_untouched(self, target: Path) -> bool:
        """Whether what has taken the name is still there."""
        if self.table["taken"] == "folder":
            return (target / "inside").is_dir()
        return target.is_fifo() and target.is_symlink() == (self.table["taken"] == "link to a pipe")

    def _call(self, folder: bytes, count: int, number: int, ever: bool) -> None:
        function = ctypes.CDLL(None).bad_disk
        function(folder, ctypes.c_long(count), ctypes.c_int(number), ctypes.c_int(ever))
