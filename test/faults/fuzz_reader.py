#!/usr/bin/env python3
"""Coverage-guided fuzzing of the reader of logs. Arguments: of libFuzzer, and a corpus."""
from pathlib import Path
import sys
import tempfile

import atheris

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
with atheris.instrument_imports(include=['bristle_ros']):
    from bristle_ros.log import reader as mcap_reader, recording
    from bristle_ros.verbs import recover
    from bristle_ros.scene.error import SceneError

PLACE = Path(tempfile.mkdtemp(prefix='fuzz_'))


def read(content):
    """Read a file and make a new one of it: SceneError is the only way to refuse."""
    log, output = PLACE / 'a.mcap', PLACE / 'b.mcap'
    log.write_bytes(mcap_reader.MAGIC + content)
    output.unlink(missing_ok=True)
    try:
        found = recording.Recording(log)
        left = sum(1 for record in found.records() if isinstance(record, mcap_reader.Message))
        if left:
            saved = recover.recover(log, output)
            assert saved.messages == left
            again = recording.Recording(output)
            assert left == sum(isinstance(record, mcap_reader.Message)
                               for record in again.records())
            assert not again.cut
            assert not again.damage
        found.scene  # noqa: B018
        for entry in found.entries():
            assert entry.step >= 0
    except SceneError as error:
        assert '\n' not in str(error)


if __name__ == '__main__':
    atheris.Setup(sys.argv, read)
    atheris.Fuzz()
