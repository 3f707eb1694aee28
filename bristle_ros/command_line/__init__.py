"""What the command lines of all verbs share: parser, interrupts, whole files."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .interrupt import is_compiling as is_compiling, leave_while_loading as leave_while_loading
    from .parser import (add_scene as add_scene, check_range as check_range,
                         load_scene as load_scene, Parser as Parser)
    from .scenes import scene_files as scene_files
    from .whole_file import (check_new as check_new, check_place as check_place,
                             INTERRUPTED as INTERRUPTED, partial as partial,
                             StopSignals as StopSignals, Undisturbed as Undisturbed,
                             WholeFile as WholeFile)

__getattr__, __dir__ = lazily(__name__, {
    'interrupt': ['is_compiling', 'leave_while_loading'],
    'parser': ['add_scene', 'check_range', 'load_scene', 'Parser'],
    'scenes': ['scene_files'],
    'whole_file': ['check_new', 'check_place', 'INTERRUPTED', 'partial', 'StopSignals',
                   'Undisturbed', 'WholeFile'],
})
