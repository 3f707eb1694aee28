"""What to simulate: keys, ranges and units, and every refusal of a value. No numba."""
from typing import TYPE_CHECKING

from bristle_ros.lazy import lazily

if TYPE_CHECKING:
    from .error import SceneError as SceneError, spell as spell
    from .key import LISTS as LISTS
    from .machine import carrying_refusal as carrying_refusal, follows_mount as follows_mount
    from .parameter_file import read_file as read_file, read_scalar as read_scalar
    from .presets import PRESETS as PRESETS
    from .road_profile import Spline as Spline, spline as spline, waves as waves
    from .scene import (depth_refusal as depth_refusal, describe_keys as describe_keys,
                        from_arguments as from_arguments, from_parameters as from_parameters,
                        gutter_friction as gutter_friction, keys as keys, load as load,
                        LONGEST as LONGEST, Scene as Scene, steps as steps,
                        to_parameters as to_parameters, to_yaml as to_yaml,
                        with_contents as with_contents)
    from .rows import (bristle_count as bristle_count, brush_rows as brush_rows,
                       longest as longest, reach as reach, Row as Row, tip_depth as tip_depth,
                       widest as widest)
    from .sections import (Air as Air, Bristle as Bristle, Brush as Brush, Contact as Contact,
                           Damping as Damping, Drive as Drive, Friction as Friction, Road as Road,
                           Run as Run, Solver as Solver, Sweeper as Sweeper)
    from .drive_table import speed_table as speed_table, start_speed as start_speed
    from .surface import (cross_section as cross_section, Gutter as Gutter,
                          is_uneven as is_uneven, Piece as Piece, Profile as Profile)
    from .surface_mesh import SurfaceMesh as SurfaceMesh, SurfaceMesher as SurfaceMesher

__getattr__, __dir__ = lazily(__name__, {
    'error': ['SceneError', 'spell'],
    'key': ['LISTS'],
    'machine': ['carrying_refusal', 'follows_mount'],
    'parameter_file': ['read_file', 'read_scalar'],
    'presets': ['PRESETS'],
    'road_profile': ['Spline', 'spline', 'waves'],
    'scene': ['depth_refusal', 'describe_keys', 'from_arguments', 'from_parameters',
              'gutter_friction', 'keys', 'load', 'LONGEST', 'Scene', 'steps',
              'to_parameters', 'to_yaml', 'with_contents'],
    'rows': ['bristle_count', 'brush_rows', 'longest', 'reach', 'Row', 'tip_depth', 'widest'],
    'sections': ['Air', 'Bristle', 'Brush', 'Contact', 'Damping', 'Drive', 'Friction', 'Road',
                 'Run', 'Solver', 'Sweeper'],
    'drive_table': ['speed_table', 'start_speed'],
    'surface': ['cross_section', 'Gutter', 'is_uneven', 'Piece', 'Profile'],
    'surface_mesh': ['SurfaceMesh', 'SurfaceMesher'],
})
