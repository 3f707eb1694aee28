from glob import glob
import os
import re

from setuptools import find_packages, setup

package_name = 'bristle_ros'
verbs = ['brush_node', 'simulate', 'static', 'replay', 'recover', 'plot', 'report', 'bench']

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), package_name, '__init__.py'),
          encoding='utf-8') as file:
    version = re.search(r"^__version__ = '(.+)'$", file.read(), re.MULTILINE).group(1)

setup(
    name=package_name,
    version=version,
    description='A rotating brush of flexible bristles on a road, for ROS 2',
    license='Apache-2.0',
    maintainer='bristle_ros maintainers',
    maintainer_email='maintainers@bristle-ros.example',
    packages=find_packages(include=[package_name, package_name + '.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/config', sorted(glob('config/*'))),
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
        'test': ['hypothesis', 'mcap-ros2-support', 'pytest', 'selenium'],
    },
    zip_safe=False,
    entry_points={
        'console_scripts': [f'{verb} = {package_name}.__main__:{verb}' for verb in verbs]},
)
