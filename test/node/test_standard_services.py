"""The services of simulation_interfaces on a real node, with the package built for it."""
from importlib import import_module
import math
import re
import sys

from interfaces import build, can_build
from nodes import Brush, ROOT, seconds
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

SCENE = (ROOT / 'test/small_brush.yaml').read_text()
CHUNK = 0.005


def standard_services(user):
    return {name for name, (type_, *_) in user.node.get_service_names_and_types()
            if type_.startswith('simulation_interfaces/')}


def documented():
    """Return the names in the reference."""
    page = (ROOT / 'docs/reference.md').read_text(encoding='utf-8')
    section = page.split('## Services of simulators')[1].split('## ')[0]
    return {f'/brush_node/{name}' for name in re.findall(r'^\| `~/(\w+)`', section, re.M)}


def test_without_the_package_nothing_changes(scene, user):
    with Brush(scene) as brush:
        user.call(SetBool, 'brush_node/pause', data=True)
        assert standard_services(user) == set()
        assert brush.end()[0] == 0


@pytest.fixture(scope='module')
def package(tmp_path_factory):
    """Return where the package is that was built."""
    return build(ROOT / 'test/simulation_interfaces', tmp_path_factory.mktemp('built'))


@pytest.fixture
def services(package):
    """Return the package's module of services."""
    sys.path.insert(0, str(package))
    yield import_module('simulation_interfaces.srv')
    sys.path.remove(str(package))


needs_compiler = pytest.mark.needs('a C++ compiler', can_build)


@needs_compiler
def test_a_brush_is_held_stepped_stopped_and_reset(scene, user, services, package):
    states = import_module('simulation_interfaces.msg').SimulationState
    results = import_module('simulation_interfaces.msg').Result

    def call(name, **request):
        type_ = getattr(services, ''.join(part.capitalize() for part in name.split('_')))
        return user.call(type_, f'brush_node/{name}', **request)

    def set_state(state):
        return call('set_simulation_state', state=states(state=state)).result.result

    with Brush(scene, path=(package,)) as brush:
        joints = user.listen(JointState, 'joint_states')
        user.until(lambda: joints, 'the brush')
        user.until(lambda: standard_services(user) == documented(), 'the services')
        assert len(documented()) == 6
        features = call('get_simulator_features').features
        assert set(features.features) == {10, 20, 22, 24, 25, 26, 31, 32}
        assert 'a chunk of 0.005 s' in features.custom_info
        assert call('get_simulation_state').state.state == states.STATE_PLAYING
        refused = call('step_simulation', steps=1).result
        assert refused.result == results.RESULT_OPERATION_FAILED
        assert refused.error_message == 'not paused: call ~/pause first; 0 of 1 done'
        assert set_state(states.STATE_PAUSED) == results.RESULT_OK
        assert set_state(states.STATE_PAUSED) == 101    # already
        assert call('get_simulation_state').state.state == states.STATE_PAUSED
        held = user.pause(joints)
        assert call('step_simulation', steps=20).result.result == results.RESULT_OK
        user.until(lambda: seconds(joints[-1]) == pytest.approx(held + 20 * CHUNK, abs=1e-9),
                   'twenty chunks')
        assert not user.came(joints)
        check_entities(call, joints[-1], results)
        assert set_state(3) == results.RESULT_FEATURE_UNSUPPORTED   # quitting
        assert call('reset_simulation', scope=1).result.result == (
            results.RESULT_FEATURE_UNSUPPORTED)     # of time
        assert set_state(states.STATE_STOPPED) == results.RESULT_OK
        assert call('get_simulation_state').state.state == states.STATE_STOPPED
        call('step_simulation', steps=1)
        user.until(lambda: joints[-1].position[0] == pytest.approx(5.0 * CHUNK), 'the start')
        assert call('get_simulation_state').state.state == states.STATE_PAUSED
        assert set_state(states.STATE_PLAYING) == results.RESULT_OK
        user.until(lambda: joints[-1].position[0] > 0.2, 'going on')
        assert call('reset_simulation').result.result == results.RESULT_OK
        user.until(lambda: joints[-1].position[0] < 0.2, 'the start')
        assert brush.end()[0] == 0


def check_entities(call, joint, results):
    """The mount of a parked brush stands still; the brush turns about its axis."""
    mount = call('get_entity_state', entity='brush_mount')
    brush = call('get_entity_state', entity='brush')
    assert mount.result.result == brush.result.result == results.RESULT_OK
    assert mount.state.header.frame_id == 'road'
    assert seconds(mount.state) == seconds(joint)
    half = 0.5 * joint.position[0]
    for state, sine, rate in ((mount.state, 0.0, 0.0), (brush.state, math.sin(half), 5.0)):
        assert state.pose.orientation.z == pytest.approx(sine, abs=1e-12)
        assert state.twist.angular.z == pytest.approx(rate, abs=1e-12)
        assert state.pose.position.z == mount.state.pose.position.z > 0.2
        assert state.twist.linear.x == state.twist.linear.y == 0.0
        assert np.isnan(state.acceleration.linear.x)
    unknown = call('get_entity_state', entity='wheel').result
    assert unknown.result == results.RESULT_NOT_FOUND
    assert "'wheel': there are brush_mount and brush" in unknown.error_message
