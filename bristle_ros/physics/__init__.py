"""Compiled kernels of the bristle: arrays and floats in, arrays changed in place."""
