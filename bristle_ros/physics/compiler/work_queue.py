"""A queue of bristles that threads share: `take(queue)` is an atomic queue[0] += 1."""
from llvmlite import ir
from numba.core import config, types
from numba.extending import intrinsic


@intrinsic
def _take(typing, queue):
    """Return queue[0], an int64, and count it up; no two threads get the same number."""
    def generate(context, builder, sig, values):
        array = context.make_array(sig.args[0])(context, builder, values[0])
        return builder.atomic_rmw('add', array.data, ir.Constant(ir.IntType(64), 1), 'monotonic')
    return types.int64(queue), generate


def _interpreted(queue):
    queue[0] += 1
    return queue[0] - 1


take = _interpreted if config.DISABLE_JIT else _take  # type: ignore[attr-defined]
