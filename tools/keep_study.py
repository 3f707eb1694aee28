#!/usr/bin/env python3
"""Print as JSON what finished studies answer, with date and machine: keep_study.py DIR..."""
from datetime import datetime, timezone
import json
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from bristle_ros.study import store  # noqa: E402
from bristle_ros.study.answer import answer, MAIN  # noqa: E402
from bristle_ros.study.study_file import restored  # noqa: E402


def kept(folder):
    """Return what is worth keeping of a study's directory."""
    found = store.description(folder)
    study, table = restored(found['study']), store.table(folder)
    told = answer(study, folder, table)
    keys = [factor.key for factor in study.factors]
    wall = [seconds for seconds in table['wall_time'].to_pylist() if seconds is not None]
    made = (Path(folder) / store.DESCRIPTION).stat().st_mtime
    return {'date': datetime.fromtimestamp(made, timezone.utc).strftime('%Y-%m-%d'),
            'machine': found['machine'], 'runs': study.runs, 'run_seconds': round(sum(wall), 1),
            'answer': told.lines, 'notes': told.notes, 'indices': told.indices,
            'best': [{name: row[name] for name in ('run', *keys, *MAIN, *(
                f'{main}_ci95' for main in MAIN if f'{main}_ci95' in row))}
                     for row in told.best[:5]]}


if __name__ == '__main__':
    print(json.dumps({Path(folder).name: kept(folder) for folder in sys.argv[1:]}, indent=1))
