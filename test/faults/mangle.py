"""Input with random damage, to the verbs that take it: each answers with one line, or works."""
import contextlib
import io

from bristle_ros.__main__ import main
from promises import promise

LETTERS = [bytes([code]) for code in range(32, 127)] + [b'\n', b'\t']
WORDS = (b'\xff', b'\0', b': ', b'- ', b'1e999', b'.nan', b'{', b'&a ', b'*a', b'!!', b'\n',
         b'null', b'"', b'<<: ', '\u00e9'.encode(), b'99999999999999999999', b'0x10', b'1_0')


def damaged(content, rng, text=False):
    """Return bytes with a few places changed, cut out, doubled or filled; if text, by letters."""
    content = bytearray(content)
    for _ in range(rng.randint(1, 2 if text else 4)):
        at = rng.randrange(len(content) or 1)
        length = rng.choice((1, 1, 1, 4, 40, 4000))
        kind = rng.randrange(5)
        if kind == 0:
            content[at:at + 1] = rng.choice(LETTERS) if text else rng.randbytes(1)
        elif kind == 1:
            del content[at:at + length]
        elif kind == 2:
            content[at:at] = content[at:at + length]
        elif kind == 3:
            content[at:at + length] = (b''.join(rng.choices(LETTERS, k=min(length, 4))) if text
                                       else rng.randbytes(length))
        else:
            content[at:at] = rng.choice(WORDS)
    return bytes(content)


def answer(*arguments):
    """Do a verb; check its answer; return its exit code."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(list(map(str, arguments)))
    promise(code in (0, 1, 2), f'{arguments}: exit code {code}')
    promise(code != 2 or err.getvalue().count('\n') == 1,
            f'{arguments}: not one line: {err.getvalue()!r}')
    return code


def mangle(place, rng, times, scene, log):
    """Damage each kind of input so often; return how many of each were refused."""
    refused = {'scene': 0, 'parameters': 0, 'log': 0}
    scene_path, log_path = place / 'mangled.yaml', place / 'mangled.mcap'
    for number in range(times):
        scene_path.write_bytes(damaged(scene, rng, text=True))
        refused['scene'] += answer('scene', scene_path) == 2
        key, _, value = rng.choice(PARAMETERS).partition(':=')
        value = damaged(value.encode(), rng, text=True).decode(errors='replace')
        value = value.replace('\0', '')
        scene_path.write_bytes(scene)
        refused['parameters'] += answer('scene', scene_path, '-p', f'{key}:={value}') == 2
        if number % 4 == 0:
            log_path.write_bytes(damaged(log, rng)[:rng.randrange(100, len(log) + 100)])
            output = place / 'mangled_recovered.mcap'
            output.unlink(missing_ok=True)
            code = answer('recover', log_path)
            refused['log'] += code == 2
            if code == 0:
                answer('recover', output, '--output', place / 'again.mcap')
                (place / 'again.mcap').unlink()
    return {'tried': times, **{f'{name} refused': count for name, count in refused.items()}}


PARAMETERS = ('road.penetration:=0.01', 'sweeper.velocity:=[1.0, 0.5]', 'log.path:="run"',
              'solver.step:=adaptive', 'contact.enabled:=true', 'brush.bristle_count:=3')
