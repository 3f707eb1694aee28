"""What README and docs say: commands are run, or checked word by word; tables are fresh."""
import ast
from importlib import import_module
import os
from pathlib import Path
import re
import shlex
import signal
import subprocess
import sys

from bristle_ros import __main__ as command_line
from bristle_ros.scene.scene import keys, load
import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob('*.md'), *ROOT.glob('docs/*.md')])
README = (ROOT / 'README.md').read_text(encoding='utf-8')
LIMIT = 600.0   # [s] before a wait is a failure: compiling on a busy machine takes minutes


def section(title):
    """Return the text of README's section of that title."""
    [found] = re.findall(rf'^## {re.escape(title)}\n(.+?)(?=^## |\Z)', README, re.DOTALL | re.M)
    return found


def blocks(text, language='sh'):
    """Return the fenced blocks of a language, each as its lines."""
    found = re.findall(rf'^( *)```{language}\n(.+?)^\1```$', text, re.DOTALL | re.M)
    return [[line.removeprefix(indent) for line in block.splitlines()] for indent, block in found]


@pytest.fixture(scope='module')
def checkout(tmp_path_factory):
    """Make a checkout whose run.sh takes the environment that the tests run in."""
    folder = tmp_path_factory.mktemp('docs') / 'bristle_ros'
    (folder / 'tools').mkdir(parents=True)
    for name in ('bristle_ros', 'config', 'examples', 'run.sh'):
        (folder / name).symlink_to(ROOT / name)
    (folder / 'tools/venv.sh').write_text(f'prepare_venv() {{ python={sys.executable}; }}\n')
    return folder


def start(line, folder):
    words = shlex.split(line)
    words[0] = {'python3': sys.executable}.get(words[0], words[0])
    environment = {name: value for name, value in os.environ.items() if name != 'PYTHONPATH'}
    return subprocess.Popen(words, cwd=folder, env=environment, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, start_new_session=True)


def run(line, folder):
    """Run a line of a document; return what it printed."""
    process = start(line, folder)
    try:
        printed = process.communicate(timeout=LIMIT)[0]
    finally:
        process.kill()
    assert process.returncode == 0, f'{line}\n{printed}'
    return printed


def test_the_first_five_minutes(checkout):
    [[begin], meanwhile, afterwards, *more] = blocks(section('Five minutes'))
    assert not more
    node = start(begin, checkout)
    try:
        for line in node.stdout:
            if 'ready' in line:
                break
        else:
            pytest.fail('the node ended before it was ready')
        printed = [run(line, checkout) for line in meanwhile]
        node.send_signal(signal.SIGINT)
        node.communicate(timeout=LIMIT)
    finally:
        node.kill()
    assert node.returncode == 0
    before, after = (table.splitlines()[1:] for table in (printed[0], printed[-1]))
    assert len(before) == len(after) == 5
    heights = [float(lines[-1].split(',')[-1]) for lines in (before, after)]
    assert heights[1] > heights[0] + 3.0    # [mm] the commanded penetration lifts the tip
    assert all(text.startswith('sent cmd_') for text in printed[1:-1])
    verdict, drawn = (run(line, checkout) for line in afterwards)
    assert re.search(r'identical: \d+ messages, 2 commands', verdict), verdict
    assert (checkout / drawn.split()[-1]).read_bytes().startswith(b'\x89PNG')


def test_commands_without_ros(checkout):
    [lines] = blocks(section('Without ROS'))
    for line in lines:
        assert line.startswith('python3 -m bristle_ros ')
        assert run(line, checkout)
    verbs = {line.split()[3] for line in lines}
    assert {'simulate', 'static', 'plot', 'scene', 'bench'} <= verbs
    assert (checkout / 'run.npz').is_file()
    assert (checkout / 'run.pdf').is_file()


def test_python_snippets(checkout):
    [lines] = blocks(section('Without ROS'), 'python')
    done = subprocess.run([sys.executable, '-c', '\n'.join(lines)], cwd=checkout, text=True,
                          capture_output=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    force, tip = done.stdout.splitlines()
    assert 0.0 < float(force.split()[0]) < 1.0
    assert tip.startswith('[')


def table_of(title):
    """Return the rows of a table of docs/reference.md as tuples of texts, by first cell."""
    page = (ROOT / 'docs/reference.md').read_text(encoding='utf-8')
    [text] = re.findall(rf'^## {re.escape(title)}\n(.+?)(?=^## |\Z)', page, re.DOTALL | re.M)
    rows = [[cell.strip().strip('`') for cell in line.strip('| ').split(' | ')]
            for line in text.splitlines() if line.startswith('| `')]
    assert rows
    return {row[0]: row[1:] for row in rows}


def fill(message, values):
    """Set the fields of a message from YAML, as `ros2 topic pub` does."""
    fields = message.get_fields_and_field_types()
    for name, value in values.items():
        assert name in fields, f'{type(message).__name__} has no {name}'
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)


def message_of(type_name):
    package, kind, name = type_name.split('/')
    return getattr(import_module(f'{package}.{kind}'), name)


def check_launch(words):
    package, file, *given = words
    assert package == 'bristle_ros'
    tree = ast.parse((ROOT / 'launch' / file).read_text(encoding='utf-8'))
    [arguments] = [ast.literal_eval(node.value) for node in tree.body
                   if isinstance(node, ast.Assign) and node.targets[0].id == 'ARGUMENTS']
    values = dict(word.split(':=') for word in given)
    assert set(values) <= {name for name, *_ in arguments}
    assert (ROOT / 'config' / f'{values["scene"]}.yaml').is_file()


def check_run(words):
    package, verb, *arguments = words
    assert package == 'bristle_ros'
    assert verb in command_line.VERBS
    printed = subprocess.run([sys.executable, '-m', 'bristle_ros', verb, '--help'], cwd=ROOT,
                             capture_output=True, text=True, timeout=LIMIT).stdout
    for word in arguments:
        assert not word.startswith('--') or word in printed
        if word.endswith('.yaml'):
            assert load(ROOT / word)


def check_topic(words):
    action, *words = words
    if action == 'echo':
        assert words[0].lstrip('/') in table_of('Topics that the node publishes')
        return
    assert action == 'pub'
    rate = words.pop(0)
    if rate == '--rate':
        assert float(words.pop(0)) > 0
    else:
        assert rate == '--once'
    name, type_name, values = words
    assert table_of('Topics that the node subscribes to')[name.lstrip('/')][0] == type_name
    fill(message_of(type_name)(), yaml.safe_load(values))


def check_service(words):
    action, name, type_name, *values = words
    assert action == 'call'
    found = table_of('Services')[name.replace('/brush_node/', '~/')]
    assert found[0] == type_name
    fill(message_of(type_name).Request(), yaml.safe_load(values[0]) if values else {})


def check_param(words):
    action, node, name, value = words
    assert (action, node) == ('set', '/brush_node')
    assert name == 'run.real_time_factor'   # the one that is not read-only
    [key] = [key for key in keys() if key.name == name]
    assert key.check(yaml.safe_load(value)) == float(value)


def check_bag(words):
    action, log = words
    assert action in ('info', 'play')
    assert f'log:={log}' in README


CHECKS = {'launch': check_launch, 'run': check_run, 'topic': check_topic,
          'service': check_service, 'param': check_param, 'bag': check_bag}


@pytest.mark.parametrize('line', [line for block in blocks(section('With ROS 2 tools'))
                                  for line in block])
def test_ros2_commands(line):
    """ros2cli is not on PyPI: each word is held against what the command would talk to."""
    ros2, verb, *words = shlex.split(line)
    assert ros2 == 'ros2'
    CHECKS[verb](words)


@pytest.mark.parametrize('line', [
    'ros2 topic echo /contact_wrenches', 'ros2 run bristle_ros replay run2 --speed 2',
    'ros2 topic pub --once /cmd_vel geometry_msgs/msg/Twist "{linear: {x: 1.0}}"',
    'ros2 topic pub --once /cmd_brush_speed std_msgs/msg/Float64 "{value: 1.0}"',
    'ros2 service call /brush_node/pause std_srvs/srv/Trigger',
    'ros2 launch bristle_ros brush.launch.py scenes:=tilted_sweep'])
def test_the_checks_can_fail(line):
    _, verb, *words = shlex.split(line)
    with pytest.raises((AssertionError, KeyError)):
        CHECKS[verb](words)


def test_installing_names_what_there_is():
    wheels, colcon = blocks(section('Installing'))
    requirements = (ROOT / 'requirements.txt').read_text(encoding='utf-8')
    named = set(shlex.split(wheels[0])[2:])
    assert named == set(re.findall(r'^(ros-jazzy-[a-z-]+)==', requirements, re.M))
    assert wheels[1] == 'pip install .'     # test_package.py does that
    manifest = (ROOT / 'package.xml').read_text(encoding='utf-8')
    assert f'<name>{colcon[-1].split()[-1]}</name>' in manifest
    for package in ('mcap', 'rosbags'):     # what pip brings is what rosdep cannot
        assert package in colcon[1]
        assert f'<exec_depend>python3-{package}</exec_depend>' not in manifest


def test_the_reference_is_fresh():
    done = subprocess.run([sys.executable, 'tools/make_reference.py'], cwd=ROOT, text=True,
                          capture_output=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    assert done.stdout == (ROOT / 'docs/reference.md').read_text(encoding='utf-8'), (
        'run tools/make_reference.py > docs/reference.md')


def test_run_help_lists_every_verb(checkout):
    assert f' {" ".join(command_line.VERBS)}\n' in run('./run.sh --help', checkout)


def test_scenes_of_the_readme_are_those_of_the_package():
    listed = set(re.findall(r'^\| `(\w+)` \|', section('Scenes'), re.M))
    assert listed == {path.stem for path in (ROOT / 'config').glob('*.yaml')}


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding='utf-8')
    for target in re.findall(r'\]\(([^)]+)\)', text):
        assert re.match(r'https?://', target) or (page.parent / target.split('#')[0]).exists(), (
            target)


def test_messages_of_troubleshooting_exist():
    """What a user would search for is what the program says."""
    page = (ROOT / 'docs/troubleshooting.md').read_text(encoding='utf-8')
    source = '\n'.join(path.read_text(encoding='utf-8')
                       for path in (ROOT / 'bristle_ros').rglob('*.py'))
    source = re.sub(r"'\s*\n\s*f?'", '', source)     # texts that go over several lines
    quoted = [part for line in page.splitlines() if line.startswith('|')
              for text in re.findall(r'`([^`]+)`', line.split(' | ')[0])
              for part in re.split(r'\.\.\.|cmd_', text) if len(part) > 8 and ' ' in part]
    quoted = [text for text in quoted if 'shared object' not in text and '=' not in text
              and '--' not in text]     # the loader's; and commands, which are tested elsewhere
    assert len(quoted) >= 5
    for text in quoted:
        assert text.strip(' :') in source, text


def test_the_picture_is_small():
    picture = (ROOT / 'docs/cutting_brush.png').read_bytes()
    assert picture.startswith(b'\x89PNG')
    assert len(picture) < 200_000
