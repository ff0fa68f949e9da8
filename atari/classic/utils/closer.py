"""`Closer`: closes objects that are open when the interpreter exits."""

import atexit
import threading
import weakref
from typing import Any


class Closer:
    """Closes the registered objects that are still there when the interpreter exits.

    An object registers itself, unregisters itself in its `close`, and calls `close` in its `__del__`.

    Args:
        atexit_register: False leaves it to the script to call `close`.
    """

    def __init__(self, atexit_register: bool = True) -> None:
        self.lock = threading.Lock()
        self.next_id = -1
        self.closeables: weakref.WeakValueDictionary[int, Any] = weakref.WeakValueDictionary()
        if atexit_register:
            atexit.register(self.close)

    def generate_next_id(self) -> int:
        """A number that no other object of this closer has."""
        with self.lock:
            self.next_id += 1
            return self.next_id

    def register(self, closeable: Any) -> int:
        """Close an object at exit; returns its number for `unregister`.

        Raises:
            TypeError: it has no `close`.
        """
        if not callable(getattr(closeable, "close", None)):
            raise TypeError(f"a Closer closes objects that have a method close(), got {closeable!r}")
        number = self.generate_next_id()
        self.closeables[number] = closeable
        return number

    def unregister(self, id: int) -> None:
        """Forget the object of a number; without effect if it is gone."""
        self.closeables.pop(id, None)

    def close(self) -> None:
        """Close all objects, in the order in which they were registered."""
        for _, closeable in sorted(self.closeables.items(), key=lambda item: item[0]):
            closeable.close()
