"""A scene's keys as ROS parameters: described, ranged, and fixed from configure on."""
from array import array
from contextlib import contextmanager

from bristle_ros.scene import from_parameters, keys, LISTS, SceneError, to_parameters
from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)

from .clocks import SIM_TIME

REAL_TIME_FACTOR = 'run.real_time_factor'
_INT64 = 2**63 - 1


def declare(node, on_real_time_factor):
    """
    Declare every key of `node.scene`; the values are the scene's, already checked.

    They can be set while the node is unconfigured, and `node.scene` is then the scene that they
    make; after that only the real-time factor, told to on_real_time_factor(factor).
    """
    by_name = {key.name: key for key in keys()}
    values = to_parameters(node.scene)
    node.declare_parameters(
        '', [(name, values[name], describe(key)) for name, key in by_name.items()],
        ignore_override=True)  # rcl's own overrides: the scene has been made from them

    follows = node.get_parameter(SIM_TIME).value

    def check(parameters):
        given = {parameter.name: parameter.value for parameter in parameters}
        if given.get(SIM_TIME, follows) != follows:
            return _refused(f'{SIM_TIME} is fixed when the node starts')
        if follows and REAL_TIME_FACTOR in given:
            return _refused(f'with {SIM_TIME}, /clock sets the pace')
        fixed = sorted(given.keys() & by_name.keys() - {REAL_TIME_FACTOR})
        if fixed and not node.unconfigured:
            return _refused(f'{fixed[0]} is fixed while the node is configured: clean it up '
                            '(lifecycle cleanup), set it, and configure again')
        try:
            _changed(node.scene, given)
        except SceneError as error:
            return _refused(str(error))
        return SetParametersResult(successful=True)

    def take(parameters):
        given = {parameter.name: parameter.value for parameter in parameters}
        if node.unconfigured:
            node.scene = _changed(node.scene, given)
        if REAL_TIME_FACTOR in given:
            on_real_time_factor(float(given[REAL_TIME_FACTOR]))

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(take)


def _changed(scene, given):
    """Return the scene with parameters of ROS in it; others are passed over. Raises SceneError."""
    values = to_parameters(scene)
    values |= {name: list(value) if isinstance(value, array) else value
               for name, value in given.items() if name in values}
    return from_parameters(values, 'parameters')


@contextmanager
def qos_overrides(node):
    """Wrap the making of topics: a bad override is one line, one without effect a warning."""
    # private: tried with rclpy 7.1.6, see test/node/test_hooks.py
    given = [name for name in node._parameter_overrides if name.startswith('qos_overrides.')]
    try:
        yield
    except Exception as error:  # rclpy raises several kinds; none of them without overrides
        if not given:
            raise
        raise SceneError(str(error), source='qos_overrides') from None
    for name in given:
        if not node.has_parameter(name):
            node.get_logger().warning(
                f'{name} has no effect: the node has no such topic, or it cannot be overridden')


def _refused(reason):
    return SetParametersResult(successful=False, reason=reason)


def describe(key):
    """Return the ParameterDescriptor of a Key."""
    unit = f' [{key.unit}]' if key.unit not in ('', '1') else ''
    descriptor = ParameterDescriptor(
        description=f'{key.description}{unit}', additional_constraints=key.range,
        # An integer is welcome where a double is meant; key.check does the judging.
        dynamic_typing=key.kind in ('float', *LISTS))
    if key.kind == 'float':
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(key.minimum), to_value=float(key.maximum))]
    if key.kind == 'int':
        descriptor.integer_range = [IntegerRange(
            from_value=int(max(key.minimum, -_INT64)), to_value=int(min(key.maximum, _INT64)))]
    return descriptor
