"""The error tolerance that adaptive steps can afford within their share of a core."""
from bristle_ros.simulation import WORST_ERROR

PERIOD = 500_000_000    # [ns] of wall time between decisions
LOW = 0.6               # share of the budget below which steps may become more accurate
AIM = 0.8               # share of the budget that a decision aims at
STEPS = 8.0             # the tolerance changes by this factor at most in one decision
TIGHTEST, LOOSEST = 1e-9, WORST_ERROR   # tolerances, relative to the bristle's length


class LoadBudget:
    """
    Watches what stepping costs and says when the error tolerance should change.

    max_load : float    share of a core that stepping may take; tolerance : float    at the start
    A step's local error goes with the cube of its length, and so the tolerance with the cube of
    the load. Steps are never longer than the integration time step: a load that this alone makes
    stays, at the loosest tolerance.
    """

    def __init__(self, max_load, tolerance):
        """Start at `tolerance`, or at the loosest; nothing is known of the load yet."""
        self.tolerance = min(tolerance, LOOSEST)
        self.load = 0.0         # over the last period
        self._max_load = max_load
        self._since = None      # (now, stepping) of the last decision

    def forget(self):
        """Start a new period: what passed was no pace of ours."""
        self._since = None

    def values(self):
        """Return what /diagnostics says of it."""
        return {'load of a core': f'{self.load:.3f}', 'error tolerance': f'{self.tolerance:.3g}'}

    def decide(self, now, stepping):
        """
        Return a new tolerance, or None for no change.

        now [ns] : int    on the steady clock; stepping [ns] : int    spent in steps until now
        """
        if self._since is None:
            self._since = now, stepping
            return None
        elapsed = now - self._since[0]
        if elapsed < PERIOD:
            return None
        self.load = (stepping - self._since[1]) / elapsed
        self._since = now, stepping
        if LOW * self._max_load <= self.load <= self._max_load:
            return None
        factor = (max(self.load, 1e-3) / (AIM * self._max_load)) ** 3
        wanted = self.tolerance * min(max(factor, 1.0 / STEPS), STEPS)
        wanted = min(max(wanted, TIGHTEST), LOOSEST)
        if wanted == self.tolerance:
            return None
        self.tolerance = wanted
        return wanted
