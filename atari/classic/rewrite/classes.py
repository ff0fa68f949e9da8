"""The classes of a script that are environments or wrappers: their `step`, `reset` and older names of methods."""

import ast

from atari.classic.rewrite.environments import Environments
from atari.classic.rewrite.results import Results, info_name
from atari.classic.rewrite.script import Function, Script

_UNTIL_2017 = frozenset("_step _reset _render _close _seed _observation _action _reward _reverse_action".split())
"""Names of methods that subclasses defined until 2017."""
_HOOKS = {"_observation": "ObservationWrapper", "_reward": "RewardWrapper", "_action": "ActionWrapper"}
"""The methods that one class of wrappers calls."""


class Classes:
    """Rewrites the classes that are environments, after `Results` has rewritten what they take."""

    def __init__(self, script: Script, environments: Environments, results: Results) -> None:
        self.script = script
        self.environments = environments
        self.results = results

    def rewrite(self) -> None:
        """Edit each class."""
        renamed: set[str] = set()
        for node, kind in self.environments.classes.items():
            is_current = self.environments.is_current(node)
            for method in [each for each in node.body if isinstance(each, Function)]:
                renamed |= self._rename(node, method)
                if is_current:
                    continue
                name = method.name.lstrip("_")
                if name == "step":
                    self._step(method)
                elif name == "reset" and not method.name.startswith("__"):
                    self._reset(node, kind, method)
                elif name == "render" and kind != "wrapper" and len(method.args.args) > 1:
                    self.script.mark(
                        method, "the constructor gets the render mode now (render_mode=), render() nothing"
                    )
        self._calls_of(renamed)
        self._metadata()
        if not self.environments.careful:
            self._arrays()

    def _rename(self, node: ast.ClassDef, method: Function) -> set[str]:
        """Edit the name of a method of 2017."""
        others = {each.name for each in node.body if isinstance(each, Function)}
        if self.environments.careful and not self._is_hook(node, method.name, others):
            return set()
        if method.name not in _UNTIL_2017 or method.name[1:] in others:
            return set()
        source = self.script.source
        start = source.text.index(method.name, source.start(method))
        source.replace(start, start + 1, "")
        return {method.name}

    def _is_hook(self, node: ast.ClassDef, name: str, others: set[str]) -> bool:
        """Whether a method would be called under its new name, and is no helper of a class for Gymnasium."""
        wrapper = _HOOKS.get(name)
        bases = [(self.script.qualified(base) or "").rpartition(".")[2] for base in node.bases]
        return wrapper in bases if wrapper is not None else not others & {"step", "reset"}

    def _calls_of(self, renamed: set[str]) -> None:
        for node in self.script.walk(ast.Attribute):
            if isinstance(node, ast.Attribute) and node.attr in renamed and self.environments.kind(node.value) == "env":
                end = self.script.source.end(node)
                self.script.source.replace(end - len(node.attr), end - len(node.attr) + 1, "")

    def _metadata(self) -> None:
        for node in self.script.walk(ast.Constant):
            new = {"render.modes": "render_modes", "video.frames_per_second": "render_fps"}.get(node.value)  # type: ignore[attr-defined]
            if new is not None:
                text = self.script.source.segment(node)
                self.script.source.replace_node(node, f"{text[0]}{new}{text[0]}")

    def _arrays(self) -> None:
        """Edit `__array__(self, dtype=None)` of lazy frames, to which NumPy 2 gives `copy`, too."""
        for method in self.script.walk(Function):  # type: ignore[arg-type]
            if isinstance(method, Function) and method.name == "__array__" and len(method.args.args) == 2:
                arguments = method.args
                if arguments.kwarg is None and not arguments.kwonlyargs:
                    self.script.source.after((arguments.defaults or arguments.args)[-1], ", copy=None")

    def _step(self, method: Function) -> None:
        """Edit what the `step` of a class returns."""
        for node in self.script.own(method, ast.Return):
            value = node.value if isinstance(node, ast.Return) else None
            if isinstance(value, ast.Tuple) and len(value.elts) == 4:
                self._five(method, value)
            elif not (isinstance(value, ast.Tuple) and len(value.elts) == 5) and not self.environments.is_step(value):
                self.script.mark(node, "step() must return observation, reward, terminated, truncated, info")

    def _five(self, method: Function, value: ast.Tuple) -> None:
        source, done = self.script.source, value.elts[2]
        text = source.segment(done)
        ended, cut = self.results.ended
        splits = [statement for name, statement in self.results.split.get(method, []) if name == text]
        if not splits:
            any_split = self.results.split.get(method)
            source.after(done, f", {cut}" if any_split else ", False")
            if any_split:
                self.script.mark(value, f"{text} may contain `{cut}` here: check the third value")
        elif self._is_changed(method, text, splits[0]):
            source.replace_node(done, f"{text} and not {cut}, {cut}")
        else:
            source.replace_node(done, f"{ended}, {cut}")

    def _is_changed(self, method: Function, done: str, step: ast.Assign) -> bool:
        """Whether a `done` gets another value than `step` gave, other than before it."""
        loops = [each for each in self.script.above(step) if isinstance(each, ast.For | ast.While)]
        for node in self.script.own(method, ast.Assign, ast.AugAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]  # type: ignore[attr-defined]
            if node is step or done not in [self.script.source.segment(each) for each in targets]:
                continue
            if node.lineno > step.lineno or any(loop in loops for loop in self.script.above(node)):  # type: ignore[attr-defined]
                return True
        return False

    def _reset(self, node: ast.ClassDef, kind: str, method: Function) -> None:
        """Edit the parameters of the `reset` of a class, its seed, and what it returns."""
        source, arguments = self.script.source, method.args
        names = {each.arg for each in (*arguments.args, *arguments.kwonlyargs)}
        takes_all = arguments.kwarg is not None
        if not takes_all and "seed" not in names and arguments.args:
            last = max([*arguments.args, *arguments.defaults], key=source.end)
            source.after(last, ", **kwargs" if kind == "wrapper" else ", *, seed=None, options=None")
            if kind == "wrapper":
                self._pass_on(method)
            else:
                self._seed(node, kind, method)
        found = None
        for statement in method.body:
            value = statement.value if isinstance(statement, ast.Assign) else None
            if self.environments.is_reset(value) and found is None:
                found = info_name(self.script, self.environments, statement)
        for each in self.script.own(method, ast.Return):
            if isinstance(each, ast.Return) and each.value is not None:
                self._two(each.value, found)

    def _pass_on(self, method: Function) -> None:
        """Give the arguments of a wrapper's `reset` to that of its environment."""
        for call in self.script.own(method, ast.Call):
            if isinstance(call, ast.Call) and self.environments.is_reset(call) and not (call.args or call.keywords):
                self.script.source.add_argument(call, "**kwargs")

    def _seed(self, node: ast.ClassDef, kind: str, method: Function) -> None:
        """Insert the seeding at the start of an environment's `reset`."""
        methods = {each.name for each in node.body if isinstance(each, Function)}
        if methods & {"seed", "_seed"}:
            text = "if seed is not None:\n    self.seed(seed)"
        elif kind == "env":
            text = "super().reset(seed=seed)"
        else:
            return
        body = [
            each for each in method.body if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))
        ]
        first = (body or method.body)[0]
        source = self.script.source
        if not source.begins_line(first):
            source.before(first, f"{text}; " if "super" in text else "seed is None or self.seed(seed); ")
            return
        indent = source.indent(first.lineno)
        source.before(first, "".join(f"{line}{source.newline}{indent}" for line in text.split("\n")))

    def _two(self, value: ast.expr, info: str | None) -> None:
        """Edit the observation that a `reset` returns into observation and info."""
        source = self.script.source
        is_two = self.environments.careful and isinstance(value, ast.Tuple) and len(value.elts) == 2
        if is_two or self.environments.is_reset(value):
            return
        if isinstance(value, ast.Tuple) and source.text[source.start(value)] != "(":
            source.before(value, "(")
            source.after(value, ")")
        source.after(value, f", {info or '{}'}")
