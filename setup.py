import ast
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

package_name = 'bristle_ros'
package = Path(__file__).resolve().parent / package_name


def literal(module, name):
    """Return the value that a module gives a name; importing it would take what it imports."""
    body = ast.parse((package / module).read_text(encoding='utf-8')).body
    [value] = [node.value for node in body if isinstance(node, ast.Assign)
               and [getattr(target, 'id', '') for target in node.targets] == [name]]
    return ast.literal_eval(value)


verbs = list(literal('__main__.py', 'VERBS'))

setup(
    name=package_name,
    version=literal('__init__.py', '__version__'),
    description='A rotating brush of flexible bristles on a road, for ROS 2',
    license='Apache-2.0',
    maintainer='bristle_ros maintainers',
    maintainer_email='maintainers@bristle-ros.example',
    packages=find_packages(include=[package_name, package_name + '.*']),
    package_data={package_name: ['py.typed', 'kernels/*/*/*']},     # tools/build_wheel.py
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/config', sorted(glob('config/*.*'))),
        ('share/' + package_name + '/config/studies', sorted(glob('config/studies/*.yaml'))),
        ('share/' + package_name + '/urdf', sorted(glob('urdf/*'))),
        ('share/' + package_name + '/launch', sorted(glob('launch/*.launch.py'))),
        # pip puts console scripts into bin/, where `ros2 run` does not look; these it finds.
        # colcon writes its own in their place.
        ('lib/' + package_name, ['scripts/' + verb for verb in verbs]),
    ],
    python_requires='>=3.10',
    install_requires=[
        'matplotlib>=3.5', 'mcap>=1.1,<2', 'numba>=0.60', 'numpy>=1.26', 'pyyaml>=6.0', 'rich>=13',
        'rosbags>=0.10'],
    extras_require={
        'peers': ['exudyn', 'mujoco'],
        # Python 3.11 or newer
        'study': ['dask', 'distributed', 'optuna>=4', 'pandas', 'plotly>=6', 'pyarrow', 'rainflow',
                  'SALib>=1.5', 'scipy>=1.15', 'xarray', 'zarr>=3'],
        'test': ['hypothesis', 'mcap-ros2-support', 'mypy', 'pytest', 'ruff', 'scipy', 'selenium'],
        'view': ['viser>=1.1,<2'],
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [f'{verb} = {package_name}.__main__:{verb}' for verb in verbs]},
)
