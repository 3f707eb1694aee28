"""YAML as study files have it: scalars spelt as in scene files, and no key twice."""
from bristle_ros.scene import read_scalar, SceneError
import yaml

DEEPEST = 6


def read_mapping(path):
    """Return the mapping that a file holds; raise SceneError, naming file and line."""
    try:
        with open(path, encoding='utf-8') as file:
            node = yaml.compose(file.read(), Loader=yaml.SafeLoader)
    except OSError as error:
        raise SceneError(f'cannot be read ({error.strerror}): give a study file',
                         source=str(path)) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, 'problem_mark', None)
        place = f'{path}:{mark.line + 1}' if mark else str(path)
        raise SceneError(f'not YAML: {getattr(error, "problem", None) or "not a text file"}',
                         source=place) from None
    if not isinstance(node, yaml.MappingNode):
        raise SceneError('not a study: keys are scene, vary, duration ...', source=str(path))
    return _plain(node, str(path))


def _plain(node, source, depth=0):
    """Return YAML's nodes as dicts, lists and scalars as scene files have them; no key twice."""
    place = f'{source}:{node.start_mark.line + 1}'
    if depth > DEEPEST:
        raise SceneError('nested too deep', source=place)
    if isinstance(node, yaml.SequenceNode):
        return [_plain(item, source, depth + 1) for item in node.value]
    if isinstance(node, yaml.ScalarNode):
        return read_scalar(node.value, quoted=node.style in ('"', "'"))
    found = {}
    for name, value in node.value:
        if not isinstance(name, yaml.ScalarNode):
            raise SceneError('a key must be a name', source=place)
        if name.value in found:
            raise SceneError('given twice: keep one of them', key=name.value,
                             source=f'{source}:{name.start_mark.line + 1}')
        found[name.value] = _plain(value, source, depth + 1)
    return found
