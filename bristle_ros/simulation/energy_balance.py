"""Whether the energy accounts of a run gain from nowhere."""
from .snapshot import Snapshot

GAIN = 0.2          # energy that may appear from nowhere, of the energy there is: 10 ms steps
PASSED = 0.01       # share of the energy that went through, which the balance may be off by


class EnergyBalance:
    """
    How far the accounts rise above their lowest balance, stored + dissipated - work.

    That falls by what schemes take, and rises only where something is made.
    """

    def __init__(self) -> None:
        """Begin with the first snapshot."""
        self._start = self._work = 0.0
        self._begun = False
        self._lowest = self._held = self._through = self._last = 0.0
        self.gain = self.loss = 0.0     # the largest so far

    def take(self, snapshot: Snapshot, ringing: float = 0.0) -> float:
        """
        Return by how much energy came from nowhere at this snapshot and the one before, at least.

        Of the energy there is, and a share of what went through.  ringing [J]: what is known to
        come and go.
        """
        stored = snapshot.energy_kinetic + snapshot.energy_elastic
        balance = stored + snapshot.energy_dissipated - snapshot.work_external
        if not self._begun:     # a start from equilibrium is bent already
            self._begun, self._start, self._work = True, balance, snapshot.work_external
        self._through += abs(snapshot.work_external - self._work)
        self._work = snapshot.work_external
        self._held = max(self._held, stored)
        balance -= self._start
        self._lowest = min(self._lowest, balance + ringing)
        # what went through friction is much more than what the bristle holds
        through = abs(snapshot.energy_dissipated) + self._through
        scale = self._held + PASSED * through + 1e-12
        now = (balance - ringing - self._lowest) / scale
        # the velocities at the end of a step with an impact overshoot; what is made stays
        gain, self._last = min(now, self._last), now
        self.gain = max(self.gain, gain)
        self.loss = max(self.loss, -balance / scale)
        return gain
