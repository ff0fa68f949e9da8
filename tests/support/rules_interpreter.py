"""A small interpreter of the rules in the game files, to compare them with ale-py.

The language is a subset of Python, so Python evaluates it; the interpreter provides the memories and the helpers.
"""

from collections.abc import Callable, Mapping
from functools import cache
from types import CodeType
from typing import Any

from atari.cores import ByteArray
from atari.games.rules import Rules

Memory = bytes | ByteArray


def signed(value: int) -> int:
    return ((value + 128) & 255) - 128


def vocabulary(ram: Memory, base: int = 0x80) -> dict[str, Any]:
    """The names in an expression that are not variables; `base` is the address of the first byte of `ram`."""
    memory = bytes(base) + bytes(ram)

    def between(low: int, high: int) -> bytes:
        return memory[low : high + 1]

    def bcd(*addresses: int) -> int:
        digits = [10 * (memory[address] >> 4) + (memory[address] & 15) for address in addresses]
        return sum(100**place * pair for place, pair in enumerate(digits))

    helpers: dict[str, Callable[..., int]] = {
        "bcd": bcd,
        "s8": signed,
        "count": lambda low, high, *values: sum(byte in values for byte in between(low, high)),
        "same": lambda low, high: int(len(set(between(low, high))) == 1),
        "pos_sum": lambda low, high: sum(max(signed(byte), 0) for byte in between(low, high)),
        "neg_sum": lambda low, high: sum(max(-signed(byte), 0) for byte in between(low, high)),
    }
    return {"ram": memory, **helpers, "__builtins__": {}}


def evaluate(source: str, ram: Memory, variables: Mapping[str, int], base: int = 0x80) -> int:
    """The value of one expression."""
    return int(eval(_code(source), {**vocabulary(ram, base), **variables}))


@cache
def _code(source: str) -> CodeType:
    return compile(source, "rule", "eval")


class Interpreter:
    """Evaluates the rules of a game; `step` gets the RAM after every frame."""

    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self._lines = [(name, _code(source)) for name, source in rules.step]
        self._state = dict(rules.state)

    def reset(self, ram: Memory, mode: int, xram: Memory = bytes(128)) -> dict[str, int]:
        """Begin an episode with the RAM after a reset.

        The core evaluates the rules for every frame of a reset, but only the last frame determines the state after it.
        """
        self._state = dict(self._rules.state)
        for operation in self._rules.mode_select:
            if operation.op == "set" and operation.var in self._state:
                assert operation.value is not None
                self._state[operation.var] = evaluate(operation.value, ram, {**self._state, "mode": mode})
        return self.step(ram, xram)

    def step(self, ram: Memory, xram: Memory = bytes(128)) -> dict[str, int]:
        """The values of all variables after a frame, among them `reward`, `terminal` and `lives`."""
        names = {**vocabulary(ram), "xram": bytes(0x80) + bytes(xram), **self._state}
        for name, code in self._lines:
            names[name] = int(eval(code, names))
        self._state = {name: names[name] for name in self._state}
        return {name: names[name] for name in {**self._state, **dict(self._lines)}}
