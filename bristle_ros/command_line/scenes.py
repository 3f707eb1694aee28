"""The scenes that come with the package."""
import os
from pathlib import Path
import sys


def scene_files():
    """Return the paths of the scene files of the checkout, or of those that are installed."""
    share = Path('share', 'bristle_ros', 'config')
    places = [Path(__file__).resolve().parents[2] / 'config']
    places += [Path(prefix) / share for prefix in os.environ.get(
        'AMENT_PREFIX_PATH', '').split(os.pathsep) if prefix]
    places.append(Path(sys.prefix) / share)
    found = next((place for place in places if list(place.glob('*.yaml'))), None)
    return sorted(found.glob('*.yaml')) if found else []
