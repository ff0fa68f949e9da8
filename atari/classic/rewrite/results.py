"""The results of `step` and `reset`, where a script takes them: five values for four, two for one."""

import ast

from atari.classic.rewrite.environments import Environments
from atari.classic.rewrite.script import Script, constant, last_name

ENDED, CUT = "terminated", "truncated"


class Results:
    """Rewrites the callers of `step` and `reset`.

    Attributes:
        split: for each function, the texts of the `done` that `step` gave in it.
        ended: the names of the two values in this script.
    """

    def __init__(self, script: Script, environments: Environments) -> None:
        self.script = script
        self.environments = environments
        self.split: dict[ast.AST | None, list[tuple[str, ast.Assign]]] = {}
        taken = {ENDED, CUT} & script.identifiers
        self.ended = ("is_terminated", "is_truncated") if taken else (ENDED, CUT)

    def rewrite(self) -> None:
        """Edit each place that uses a result."""
        for call in self.script.calls():
            if self.environments.is_step(call):
                self._step(call)
            elif self.environments.is_reset(call):
                self._reset(call)
        self._limits()
        self._last_observations()

    def _step(self, call: ast.Call) -> None:
        parent = self.script.parent(call)
        if isinstance(parent, ast.Expr):
            return
        if self.environments.careful:
            target = parent.targets[0] if isinstance(parent, ast.Assign) and len(parent.targets) == 1 else None
            if isinstance(parent, ast.Assign) and isinstance(target, ast.Tuple | ast.List):
                self._unpack(parent, target, call)
            return
        if isinstance(parent, ast.Return):
            function = self.script.function(call)
            if function is not None and self.script.class_of(function) in self.environments.classes:
                return
            if function is not None and self._is_called(function.name):
                return
        elif isinstance(parent, ast.Assign) and len(parent.targets) == 1:
            target = parent.targets[0]
            if isinstance(target, ast.Tuple | ast.List) and self._unpack(parent, target, call):
                return
            if isinstance(target, ast.Name) and self._named(target, call):
                return
        elif isinstance(parent, ast.Subscript) and self._index(parent):
            return
        self.script.mark(call, "step() returns five values now: observation, reward, terminated, truncated, info")

    def _is_called(self, name: str) -> bool:
        return any(last_name(call.func) == name for call in self.script.calls())

    def _unpack(self, statement: ast.Assign, target: ast.Tuple | ast.List, value: ast.expr) -> bool:
        """Edit four targets of `step`; False if they are not understood."""
        source, elements = self.script.source, target.elts
        if any(isinstance(each, ast.Starred) for each in elements):
            return False
        if len(elements) == 5:
            return True
        if len(elements) != 4:
            return False
        done = elements[2]
        text = source.segment(done)
        if text == "_":
            source.after(done, ", _")
            return True
        ended, cut = self.ended
        function = self.script.function(statement)
        self.split.setdefault(function, []).append((text, statement))
        source.replace_node(done, f"{ended}, {cut}")
        if self._is_read(done, statement):
            either = "|" if self._is_vector(value, text) else "or"
            source.statement_after(statement, f"{text} = {ended} {either} {cut}")
        return True

    def _is_vector(self, value: ast.expr, done: str) -> bool:
        receiver = value.func.value if isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute) else None
        kind = self.environments.kind(receiver) if receiver is not None else None
        return kind == "vector" or (kind is None and done.endswith("dones"))

    def _is_read(self, done: ast.expr, statement: ast.stmt) -> bool:
        """Whether a `done` is read outside of the results that the `step` of an environment's class returns."""
        function = self.script.function(statement)
        if not isinstance(done, ast.Name) or function is None or self.script.class_of(function) is None:
            return True
        if not (function.name in ("step", "_step") and self.script.class_of(function) in self.environments.classes):
            return True
        return any(
            isinstance(node, ast.Name) and node.id == done.id and node is not done and not self._is_returned(node)
            for node in ast.walk(function)
        )

    def _is_returned(self, node: ast.Name) -> bool:
        parent = self.script.parent(node)
        if not (isinstance(parent, ast.Tuple) and len(parent.elts) == 4 and parent.elts[2] is node):
            return False
        return isinstance(self.script.parent(parent), ast.Return)

    def _named(self, target: ast.Name, call: ast.Call) -> bool:
        """Edit the uses of a name that has the results of `step`; False if one is not understood."""
        function = self.script.function(call)
        scope: ast.AST = function or self.script.tree
        uses = [
            node
            for node in self.script.own(scope, ast.Name)
            if isinstance(node, ast.Name) and node.id == target.id and isinstance(node.ctx, ast.Load)
        ]
        understood = True
        for use in uses:
            parent = self.script.parent(use)
            if isinstance(parent, ast.Subscript):
                understood &= self._index(parent)
            elif isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Tuple | ast.List):
                understood &= self._unpack(parent, parent.targets[0], call)
            else:
                understood = False
        return understood

    def _index(self, node: ast.Subscript) -> bool:
        """Edit `result[i]`; False if the index is not understood."""
        source, place = self.script.source, constant(node.slice)
        if place in (0, 1):
            return True
        if place == 2:
            source.before(node, "any(")
            source.replace_node(node.slice, "2:4")
            source.after(node, ")")
            return True
        if place == 3:
            source.replace_node(node.slice, "4")
            return True
        if not isinstance(node.slice, ast.Slice) or node.slice.step is not None:
            return False
        return (node.slice.lower is None or constant(node.slice.lower) == 0) and constant(node.slice.upper) in (1, 2)

    def _reset(self, call: ast.Call) -> None:
        parent, source = self.script.parent(call), self.script.source
        if isinstance(parent, ast.Expr) or (self.environments.careful and not self._is_observation(call)):
            return
        if isinstance(parent, ast.Return):
            function = self.script.function(call)
            inside = self.script.class_of(function) if function is not None else None
            if function is not None and function.name in ("reset", "_reset") and inside in self.environments.classes:
                return
        if isinstance(parent, ast.Assign) and len(parent.targets) == 1:
            target = parent.targets[0]
            if isinstance(target, ast.Name | ast.Attribute):
                source.after(target, f", {info_name(self.script, self.environments, parent) or '_'}")
                return
        source.after(call, "[0]")

    def _is_observation(self, reset: ast.Call) -> bool:
        """Whether a script for Gymnasium takes what a `reset` returns as the observation alone, an error there."""
        parent, inside = self.script.parent(reset), self.script.class_of(reset)
        function = self.script.function(reset)
        if function is not None and function.name in ("reset", "_reset") and inside in self.environments.classes:
            return not self.environments.is_current(inside) and not _is_two(parent)
        if isinstance(parent, ast.Assign) and len(parent.targets) == 1:
            target = parent.targets[0]
            return isinstance(target, ast.Name | ast.Attribute) and not self.environments.is_pair(target)
        if not isinstance(parent, ast.Call) or last_name(parent.func) in ("print", "len", "tuple", "list", "type"):
            return False
        function = self.environments.functions.get(last_name(parent.func))
        if function is None or reset not in parent.args:
            return True
        given = function.args.args[-len(parent.args) :][parent.args.index(reset)]
        uses = [each for each in self.script.own(function, ast.Name) if each.id == given.arg]  # type: ignore[attr-defined]
        return not any(self.environments.is_pair(each) for each in uses[:1] if isinstance(each, ast.Name))

    def _limits(self) -> None:
        """Edit `info["TimeLimit.truncated"]`, which is `truncated` where `step` was unpacked."""
        for node in self.script.walk(ast.Constant):
            if constant(node) != "TimeLimit.truncated":
                continue
            use = self.script.parent(node)
            is_read = isinstance(use, ast.Subscript) and isinstance(use.ctx, ast.Load)
            is_got = isinstance(use, ast.Call) and isinstance(use.func, ast.Attribute) and use.func.attr == "get"
            if use is not None and (is_read or is_got) and self.split.get(self.script.function(node)):
                self.script.source.replace_node(use, self.ended[1])
            else:
                self.script.mark(node, "step() returns `truncated` now; info has no TimeLimit.truncated")

    def _last_observations(self) -> None:
        """Edit `infos[i]["terminal_observation"]`: the infos of a vector are one dictionary of arrays."""
        source = self.script.source
        for node in self.script.walk(ast.Constant):
            if constant(node) not in ("terminal_observation", "final_observation"):
                continue
            use = self.script.parent(node)
            if isinstance(use, ast.Subscript) and isinstance(use.value, ast.Subscript):
                base, index = source.segment(use.value.value), source.segment(use.value.slice)
                source.replace_node(use, f'{base}["final_obs"][{index}]')
            else:
                self.script.mark(node, 'a vector\'s infos are one dictionary now: infos["final_obs"][i]')


def _is_two(node: ast.AST | None) -> bool:
    """Whether a statement unpacks two values."""
    return isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple | ast.List)


def info_name(script: Script, environments: Environments, assign: ast.stmt) -> str | None:
    """The name for the info of a `reset` in the `reset` of a class, which returns it; None elsewhere."""
    function = script.function(assign)
    if function is None or function.name not in ("reset", "_reset"):
        return None
    if script.class_of(function) not in environments.classes or assign not in function.body:
        return None
    taken = any(isinstance(node, ast.Name) and node.id == "info" for node in ast.walk(function))
    return None if taken else "info"
