"""`Script`: a syntax tree with parents, scopes and the qualified names of what is imported."""

import ast
from collections.abc import Iterator

from atari.classic.rewrite.source import Source

Function = ast.FunctionDef | ast.AsyncFunctionDef
OLD = "gym"
"""The name of Gym in qualified names; `atari.classic` and Gymnasium count as Gym."""


class Script:
    """A parsed script.

    Attributes:
        source: its text, with the edits.
        tree: its syntax tree.
        names: the qualified name of each name that an import binds, such as {"np": "numpy"}.
        packages: the packages that are imported; "atari.classic" counts as one.
        imports: lines to insert after the import of Gym.

    Raises:
        SyntaxError: the text is not of this version of Python.
    """

    def __init__(self, text: str) -> None:
        self.source = Source(text)
        self.tree = ast.parse(text)
        self.imports: list[str] = []
        self._parents = {child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)}
        self.names: dict[str, str] = {}
        self.packages: set[str] = set()
        for node in self.walk(ast.Import, ast.ImportFrom):
            self._bind(node)
        self.identifiers = {node.id for node in self.walk(ast.Name)}  # type: ignore[attr-defined]

    def _bind(self, node: ast.AST) -> None:
        if isinstance(node, ast.Import):
            for alias in node.names:
                self.packages.add(_package(alias.name))
                name = alias.name if alias.asname else alias.name.partition(".")[0]
                self.names[alias.asname or name] = normal(name)
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                self.packages.add(_package(f"{node.module}.{alias.name}"))
                self.names[alias.asname or alias.name] = normal(f"{node.module}.{alias.name}")

    def walk(self, *kinds: type[ast.AST]) -> Iterator[ast.AST]:
        """Return the nodes of some kinds, in the order of the text."""
        found = [node for node in ast.walk(self.tree) if isinstance(node, kinds)]
        return iter(sorted(found, key=lambda node: (getattr(node, "lineno", 0), getattr(node, "col_offset", 0))))

    def calls(self) -> Iterator[ast.Call]:
        """The calls, in the order of the text."""
        yield from self.walk(ast.Call)  # type: ignore[misc]

    def parent(self, node: ast.AST) -> ast.AST | None:
        """The node that contains a node."""
        return self._parents.get(node)

    def above(self, node: ast.AST) -> Iterator[ast.AST]:
        """The nodes around a node, from the inside."""
        while (parent := self._parents.get(node)) is not None:
            yield parent
            node = parent

    def statement(self, node: ast.AST) -> ast.stmt:
        """The statement of a node."""
        return next(each for each in [node, *self.above(node)] if isinstance(each, ast.stmt))

    def function(self, node: ast.AST) -> Function | None:
        """The function around a node."""
        return next((each for each in self.above(node) if isinstance(each, Function)), None)

    def class_of(self, node: ast.AST) -> ast.ClassDef | None:
        """The class whose method a node is in, or is."""
        function = node if isinstance(node, Function) else self.function(node)
        while function is not None:
            parent = self._parents[function]
            if isinstance(parent, ast.ClassDef):
                return parent
            function = self.function(function)
        return None

    def block(self, statement: ast.stmt) -> list[ast.stmt]:
        """The statements of the block of a statement."""
        parent = self._parents[statement]
        for name in ("body", "orelse", "finalbody"):
            block = getattr(parent, name, [])
            if isinstance(block, list) and statement in block:
                return block
        return [statement]

    def own(self, function: ast.AST, *kinds: type[ast.AST]) -> Iterator[ast.AST]:
        """Return the nodes of some kinds in a function. Functions inside it are left out."""
        scope = function if isinstance(function, Function) else None
        for node in ast.walk(function):
            if isinstance(node, kinds) and self.function(node) is scope:
                yield node

    def qualified(self, node: ast.AST) -> str | None:
        """The full name of a name or attribute that is imported: "gym.wrappers.Monitor"."""
        if isinstance(node, ast.Name):
            return self.names.get(node.id)
        if isinstance(node, ast.Attribute):
            value = self.qualified(node.value)
            return None if value is None else normal(f"{value}.{node.attr}")
        return None

    def mark(self, node: ast.AST, text: str) -> None:
        """Mark the line in which the statement of a node begins."""
        statement = self.statement(node)
        around: list[ast.AST] = [statement, *self.above(statement)]
        for each in around:
            if isinstance(each, ast.stmt) and self.source.begins_line(each) and not self._continues(each):
                return self.source.mark(each, text)

    def _continues(self, statement: ast.stmt) -> bool:
        """Whether a statement begins in a line that another statement continues, as `if a \\` does."""
        parent = self._parents[statement]
        header = getattr(parent, "test", None) or getattr(parent, "iter", None)
        return header is not None and statement.lineno <= (header.end_lineno or 0)

    def modern(self, name: str) -> str:
        """The text for a name of Gymnasium, such as `gym.make_vec`; imports Gymnasium if no name means it."""
        for local, qualified in self.names.items():
            if qualified == OLD:
                return f"{local}.{name}"
        if "import gymnasium" not in self.imports:
            self.imports.append("import gymnasium")
        return f"gymnasium.{name}"


def _package(name: str) -> str:
    return "atari.classic" if f"{name}.".startswith("atari.classic.") else name.partition(".")[0]


def normal(name: str) -> str:
    """A qualified name in which Gym has one name, wherever it is imported from."""
    for other in ("atari.classic", "gymnasium"):
        if name == other or name.startswith(other + "."):
            return OLD + name.removeprefix(other)
    return name


def last_name(node: ast.AST) -> str:
    """The last identifier of an expression such as `self.env`; empty if there is none."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        return node.attr
    return last_name(node.value) if isinstance(node, ast.Subscript) else ""


def constant(node: ast.AST | None) -> object:
    """The value of a constant; `...` for any other expression."""
    return node.value if isinstance(node, ast.Constant) else ...


def keyword(call: ast.Call, name: str) -> ast.keyword | None:
    """An argument of a call by its name."""
    return next((each for each in call.keywords if each.arg == name), None)
