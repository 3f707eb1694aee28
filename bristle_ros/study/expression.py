"""
Expressions of measures and keys, as study files and command lines give them.

They are parsed into a tree of which a few kinds of nodes are known; nothing is ever handed to
Python to run.
"""
import ast
import difflib
import math
import operator

from bristle_ros.scene import SceneError

LONGEST = 500       # letters: what is longer is no expression that a person wrote
_FUNCTIONS = {'abs': abs, 'sqrt': math.sqrt, 'exp': math.exp, 'log': math.log, 'min': min,
              'max': max}
_OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
              ast.Div: operator.truediv, ast.Pow: math.pow, ast.USub: operator.neg,
              ast.UAdd: operator.pos}
_ABOVE, _BELOW = (ast.Gt, ast.GtE), (ast.Lt, ast.LtE)


class Expression:
    """
    A formula of named numbers.

    text : str      numbers, names, + - * / ** ( ), abs sqrt exp log min max
    names : those that it may use
    constraint : bool   whether it is one comparison, or has none
    source, key : where it stands, for the error
    Raises SceneError where it is anything else.
    """

    def __init__(self, text, names, *, constraint=False, source='', key=''):
        self.text = text
        self.used = set()

        def refuse(problem):
            raise SceneError(problem, key=key, value=text, source=source)

        if not isinstance(text, str) or not 0 < len(text) <= LONGEST:
            refuse(f'must be an expression of at most {LONGEST} letters')
        try:
            tree = ast.parse(text.strip(), mode='eval').body
            self._limits = _limits(tree) if constraint else (tree,)
            if self._limits is None:
                refuse('must be one comparison, as in normal_force_mean > 0.05')
            for part in self._limits:
                self._check(part, names, refuse)
        except SyntaxError as error:
            refuse(f'not an expression ({error.msg})')
        except (ValueError, MemoryError, RecursionError) as error:
            if isinstance(error, SceneError):
                raise
            refuse('not an expression')

    def __reduce__(self):
        """Cross a process border as text: it has been checked."""
        return Expression._again, (self.text, sorted(self.used), len(self._limits) == 2)

    @staticmethod
    def _again(text, names, constraint):
        return Expression(text, names, constraint=constraint)

    def __repr__(self):
        """Show the text."""
        return f'Expression({self.text!r})'

    def _check(self, node, names, refuse):
        if isinstance(node, ast.Constant):
            if type(node.value) not in (int, float) or not math.isfinite(float(node.value)):
                refuse(f'{node.value!r} is no number')
        elif isinstance(node, (ast.Name, ast.Attribute)):
            name = ast.unparse(node)
            if name not in names:
                near = difflib.get_close_matches(name, names, 1)
                refuse(f'{name!r} is no measure and no key of a scene that is a number' + (
                    f', did you mean {near[0]}?' if near else ''))
            self.used.add(name)
        elif isinstance(node, (ast.BinOp, ast.UnaryOp)) and type(node.op) in _OPERATORS:
            for part in _parts(node):
                self._check(part, names, refuse)
        elif isinstance(node, ast.Call) and _is_function(node):
            for part in node.args:
                self._check(part, names, refuse)
        else:
            refuse(f'{ast.unparse(node)!r} is not understood: numbers, names, + - * / ** ( ) and '
                   f'{" ".join(_FUNCTIONS)}')

    def value(self, numbers):
        """Return the value with names as `numbers` has them; NaN where there is none."""
        return self._value(self._limits[0], numbers)

    def excess(self, numbers):
        """Return by how much a constraint is broken: at most 0 where it is met, or NaN."""
        return self._value(self._limits[0], numbers) - self._value(self._limits[1], numbers)

    def _value(self, node, numbers):
        try:
            return float(_evaluate(node, numbers))
        except (ArithmeticError, ValueError, TypeError, KeyError):
            return math.nan


def _limits(tree):
    """Return (smaller, larger) of a comparison, or None."""
    if not isinstance(tree, ast.Compare) or len(tree.ops) != 1:
        return None
    left, [right], [kind] = tree.left, tree.comparators, tree.ops
    if isinstance(kind, _BELOW):
        return left, right
    return (right, left) if isinstance(kind, _ABOVE) else None


def _parts(node):
    return (node.operand,) if isinstance(node, ast.UnaryOp) else (node.left, node.right)


def _is_function(node):
    wanted = 2 if getattr(node.func, 'id', '') in ('min', 'max') else 1
    return (isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS and not node.keywords
            and (len(node.args) == 1 if wanted == 1 else len(node.args) >= 2))


def _evaluate(node, numbers):
    if isinstance(node, ast.Constant):
        return float(node.value)
    if isinstance(node, (ast.Name, ast.Attribute)):
        return float(numbers[ast.unparse(node)])
    if isinstance(node, ast.Call):
        return _FUNCTIONS[node.func.id](*(_evaluate(part, numbers) for part in node.args))
    return _OPERATORS[type(node.op)](*(_evaluate(part, numbers) for part in _parts(node)))
