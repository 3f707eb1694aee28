"""
Vectors of four or eight lanes as values in kernels: `load4(a, i)` is a[i:i + 4] in registers.

A value supports + - * / with its like and with numbers. LLVM finds vectors by itself only where
it can prove that rows don't overlap, which takes offsets it knows while compiling; with these a
kernel may loop over rows. Flags as in jit.py. No index is tested, as elsewhere in kernels.
"""
import operator

from llvmlite import ir
from numba.core import config, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
import numpy as np

_FLAGS = ('contract', 'nsz', 'arcp')


class _Lanes(types.Type):
    """The type of a vector of doubles."""

    def __init__(self, width):
        super().__init__(name=f'Lanes{width}')
        self.width = width


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):

    def __init__(self, manager, type_):
        super().__init__(manager, type_, _vector(type_.width))


def _vector(width):
    return ir.VectorType(ir.DoubleType(), width)


def _splat(builder, value, width):
    """Return a vector with the same number in all lanes."""
    index = ir.IntType(32)
    undefined = ir.Constant(_vector(width), ir.Undefined)
    first = builder.insert_element(undefined, value, ir.Constant(index, 0))
    return builder.shuffle_vector(
        first, undefined, ir.Constant(ir.VectorType(index, width), [0] * width))


def _operation(function, instruction):
    """Teach numba an operator between lanes, or lanes and a number."""
    @infer_global(function)
    class _Template(AbstractTemplate):

        def generic(self, args, kws):
            lanes = [type_ for type_ in args if isinstance(type_, _Lanes)]
            if len(args) == 2 and lanes and all(
                    type_ == lanes[0] or isinstance(type_, types.Float) for type_ in args):
                return signature(lanes[0], *args)
            return None

    def lower(context, builder, sig, values):
        width = sig.return_type.width
        x, y = (value if isinstance(type_, _Lanes) else _splat(builder, value, width)
                for type_, value in zip(sig.args, values))
        return getattr(builder, instruction)(x, y, flags=_FLAGS)

    for left, right in ((_Lanes, _Lanes), (_Lanes, types.Float), (types.Float, _Lanes)):
        lower_builtin(function, left, right)(lower)


for _function, _instruction in ((operator.add, 'fadd'), (operator.sub, 'fsub'),
                                (operator.mul, 'fmul'), (operator.truediv, 'fdiv')):
    _operation(_function, _instruction)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):

    def generic(self, args, kws):
        return signature(args[0], args[0]) if isinstance(args[0], _Lanes) else None


@lower_builtin(operator.neg, _Lanes)
def _negate(context, builder, sig, values):
    return builder.fneg(values[0], flags=_FLAGS)


def _place(context, builder, sig, values, width):
    """Return the pointer to `width` numbers from values[1] on in the flat array values[0]."""
    array = context.make_array(sig.args[0])(context, builder, values[0])
    first = builder.gep(array.data, [values[1]])
    return builder.bitcast(first, _vector(width).as_pointer())


def _access(width):
    """Make load, store (in flat, contiguous arrays), splats and moves for this width."""
    lanes = _Lanes(width)

    @intrinsic
    def load(typing, array, index):
        """Return array[index:index + width] as a vector."""
        def generate(context, builder, sig, values):
            value = builder.load(_place(context, builder, sig, values, width))
            value.align = 8
            return value
        return lanes(array, types.intp), generate

    @intrinsic
    def store(typing, array, index, value):
        """Store a vector into array[index:index + width]."""
        def generate(context, builder, sig, values):
            instruction = builder.store(
                values[2], _place(context, builder, sig, values, width))
            instruction.align = 8
            return context.get_dummy_value()
        return types.none(array, types.intp, lanes), generate

    @intrinsic
    def splat(typing, number):
        """Return a vector with the same number in all lanes."""
        def generate(context, builder, sig, values):
            return _splat(builder, values[0], width)
        return lanes(types.float64), generate

    @intrinsic
    def splat_of(typing, array, index):
        """Return a vector with array[index] in all lanes."""
        def generate(context, builder, sig, values):
            make = context.make_array(sig.args[0])(context, builder, values[0])
            return _splat(builder, builder.load(builder.gep(make.data, [values[1]])), width)
        return lanes(array, types.intp), generate

    def moved(order, lane):
        @intrinsic
        def move(typing, lanes_, number):
            def generate(context, builder, sig, values):
                return builder.insert_element(_shuffle(builder, values[0], values[0], order),
                                              values[1], ir.Constant(ir.IntType(32), lane))
            return lanes(lanes, types.float64), generate
        return move

    return (load, store, splat, splat_of,
            moved([0, *range(width - 1)], 0), moved([*range(1, width), 0], width - 1))


def _shuffle(builder, one, two, order):
    """Return the vector of those lanes, counted through both."""
    index = ir.IntType(32)
    return builder.shuffle_vector(one, two, ir.Constant(ir.VectorType(index, len(order)), order))


def _spreading():
    """Make splats6, join4 and halves8."""
    half, whole = _Lanes(4), _Lanes(8)

    @intrinsic
    def splats(typing, lanes):
        """Return six vectors: each of the first six lanes in all lanes."""
        def generate(context, builder, sig, values):
            vectors = [_shuffle(builder, values[0], values[0], [lane] * 8) for lane in range(6)]
            return context.make_tuple(builder, sig.return_type, vectors)
        return types.UniTuple(whole, 6)(whole), generate

    @intrinsic
    def join(typing, low, high):
        """Return a vector of eight lanes from two of four."""
        def generate(context, builder, sig, values):
            return _shuffle(builder, *values, list(range(8)))
        return whole(half, half), generate

    @intrinsic
    def halves(typing, lanes):
        """Return the first and the last four lanes."""
        def generate(context, builder, sig, values):
            vectors = [_shuffle(builder, values[0], values[0], list(range(first, first + 4)))
                       for first in (0, 4)]
            return context.make_tuple(builder, sig.return_type, vectors)
        return types.UniTuple(half, 2)(whole), generate

    return splats, join, halves


def _transposing():
    """Make transpose4."""
    lanes = _Lanes(4)

    @intrinsic
    def transpose(typing, a, b, c, d):
        """Return the columns of the 4 x 4 matrix with these rows."""
        def generate(context, builder, sig, values):
            one, two = (_shuffle(builder, *values[:2], [0, 4, 2, 6]),
                        _shuffle(builder, *values[:2], [1, 5, 3, 7]))
            three, four = (_shuffle(builder, *values[2:], [0, 4, 2, 6]),
                           _shuffle(builder, *values[2:], [1, 5, 3, 7]))
            low, high = [0, 1, 4, 5], [2, 3, 6, 7]
            columns = [_shuffle(builder, one, three, low), _shuffle(builder, two, four, low),
                       _shuffle(builder, one, three, high), _shuffle(builder, two, four, high)]
            return context.make_tuple(builder, sig.return_type, columns)
        return types.UniTuple(lanes, 4)(lanes, lanes, lanes, lanes), generate

    return transpose


def _interpreted(width):
    """Do the same to numpy arrays, for kernels that are not compiled (NUMBA_DISABLE_JIT)."""
    def load(array, index):
        return array[index:index + width].copy()

    def store(array, index, value):
        array[index:index + width] = value

    def splat(number):
        return np.full(width, number)

    def splat_of(array, index):
        return np.full(width, array[index])

    def push_first(lanes, number):
        return np.concatenate(([number], lanes[:-1]))

    def push_last(lanes, number):
        return np.concatenate((lanes[1:], [number]))

    return load, store, splat, splat_of, push_first, push_last


def _transposed(a, b, c, d):
    return tuple(np.array((a, b, c, d)).T)


def _spread(lanes):
    return tuple(np.full(8, number) for number in lanes[:6])


def _joined(low, high):
    return np.concatenate((low, high))


def _halved(lanes):
    return lanes[:4], lanes[4:]


_made = _interpreted if config.DISABLE_JIT else _access  # type: ignore[attr-defined]
# push_first4: all lanes one up, and a number into the first; push_last4: one down
load4, store4, splat4, _, push_first4, push_last4 = _made(4)
load8, store8, _, splat_of8, *_ = _made(8)
transpose4 = _transposed if config.DISABLE_JIT else _transposing()  # type: ignore[attr-defined]
splats6, join4, halves8 = (
    (_spread, _joined, _halved) if config.DISABLE_JIT else _spreading())  # type: ignore[attr-defined]
