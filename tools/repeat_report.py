#!/usr/bin/env python3
"""
Run the quick report several times, some beside a busy core, and hold their verdicts together.

    tools/repeat_report.py [--quiet 2] [--busy 2] [--output DIR] [arguments of report ...]

Prints how many verdicts each run left open; exit code 1 where two runs exclude each other.
"""
import argparse
from itertools import combinations
import json
from pathlib import Path
import subprocess
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))


def run(folder, busy, arguments):
    """Run a report; return its verdicts by claim and reading."""
    load = subprocess.Popen([sys.executable, '-c', 'while True: pass']) if busy else None
    try:
        subprocess.run([sys.executable, '-m', 'bristle_ros', 'report', '--quick', '--output',
                        str(folder), *arguments], cwd=ROOT, check=False)
    finally:
        if load:
            load.kill()
            load.wait()
    from bristle_ros.report.paper import claims
    results = json.loads((folder / 'results.json').read_text(encoding='utf-8'))
    if 'paper' not in results['parts']:
        return {}
    return {(row['claim'], row['reading']): row['verdict']
            for row in claims.judge(results['parts']['paper'])}


def main():
    """Run them; return the exit code."""
    from bristle_ros.report.verdict import contradict, UNDECIDED
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--quiet', type=int, default=2)
    parser.add_argument('--busy', type=int, default=2)
    parser.add_argument('--output', type=Path, default=Path('reports'))
    options, arguments = parser.parse_known_args()
    found = []
    for number in range(options.quiet + options.busy):
        busy = number >= options.quiet
        verdicts = run(options.output.resolve() / f'run{number + 1}', busy, arguments)
        found.append(verdicts)
        print(f'run {number + 1}{", beside a busy core" if busy else ""}: {len(verdicts)} '
              f'verdicts, {list(verdicts.values()).count(UNDECIDED)} {UNDECIDED}')
    turned = {key[0] for one, other in combinations(found, 2) for key in one
              if key in other and contradict(one[key], other[key])}
    for claim in sorted(turned):
        words = [verdicts[key] for verdicts in found for key in verdicts if key[0] == claim]
        print(f'turned: {claim}: {", ".join(words)}')
    print(f'{len(turned)} verdicts turned')
    return 1 if turned else 0


if __name__ == '__main__':
    sys.exit(main())
