"""
Tests that run the kernels as plain Python, on a few elements and steps: seconds, not minutes.

They are collected with NUMBA_DISABLE_JIT=1 only; compiler/test_interpreted.py runs them so.
"""
import numba

collect_ignore_glob = [] if numba.config.DISABLE_JIT else ['test_*.py']
