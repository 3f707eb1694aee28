"""The verb `plot`: a log, or the arrays of `simulate`, as one page of figures."""
