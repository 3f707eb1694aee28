"""A scene's keys as ROS parameters: described, ranged, and fixed but for the real-time factor."""
from contextlib import contextmanager

from bristle_ros.scene import keys, SceneError, to_parameters
from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)

from .clocks import SIM_TIME

REAL_TIME_FACTOR = 'run.real_time_factor'
_INT64 = 2**63 - 1


def declare(node, scene, on_real_time_factor):
    """
    Declare every key of the scene on the node; the values are the scene's, already checked.

    on_real_time_factor(factor) is called when somebody sets the one parameter that can be set.
    """
    by_name = {key.name: key for key in keys()}
    values = to_parameters(scene)
    node.declare_parameters(
        '', [(name, values[name], describe(key)) for name, key in by_name.items()],
        ignore_override=True)  # rcl's own overrides: the scene has been made from them

    follows = node.get_parameter(SIM_TIME).value

    def check(parameters):
        for parameter in parameters:
            if parameter.name == SIM_TIME and parameter.value != follows:
                return _refused(f'{SIM_TIME} is fixed when the node starts')
            if parameter.name == REAL_TIME_FACTOR:
                if follows:
                    return _refused(f'with {SIM_TIME}, /clock sets the pace')
                try:
                    by_name[parameter.name].check(parameter.value)
                except SceneError as error:
                    return _refused(str(error))
        return SetParametersResult(successful=True)

    def take(parameters):
        for parameter in parameters:
            if parameter.name == REAL_TIME_FACTOR:
                on_real_time_factor(float(parameter.value))

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(take)


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
        read_only=key.name != REAL_TIME_FACTOR,
        # An integer is welcome where a double is meant; key.check does the judging.
        dynamic_typing=key.kind in ('float', 'pair'))
    if key.kind == 'float':
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(key.minimum), to_value=float(key.maximum))]
    if key.kind == 'int':
        descriptor.integer_range = [IntegerRange(
            from_value=int(max(key.minimum, -_INT64)), to_value=int(min(key.maximum, _INT64)))]
    return descriptor
