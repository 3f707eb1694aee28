#!/usr/bin/env python3
"""
Keep a report: docs/report.json, and README's figures made from it.

    python3 -m bristle_ros report --output report && tools/keep_report.py report/results.json
"""
from pathlib import Path
import sys

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))


def main(arguments):
    """Write both; return the exit code."""
    from bristle_ros.report import readme, results
    if len(arguments) != 1:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    kept = results.kept(results.read(Path(arguments[0]), 'RESULTS'))
    results.write(ROOT / 'docs' / 'report.json', kept, indent=None)
    page = ROOT / 'README.md'
    text = readme.replaced(page.read_text(encoding='utf-8'), kept)
    page.write_text(text, encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
