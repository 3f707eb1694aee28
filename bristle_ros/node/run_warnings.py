"""What makes a run doubtful, as the node tells it: in diagnostics, a line each, in the log."""


class RunWarnings:
    """Tells the warnings of one run."""

    def __init__(self, driver, logger):
        """Take the Driver, whose watch decides, and the node's logger."""
        self._driver, self._logger = driver, logger
        self._told = set()

    def look(self):
        """
        Return (kinds that somebody must act on, diagnostics: key -> text) of the run so far.

        Each kind gets one log line when it is first found.
        """
        found = self._driver.warnings(ended=False)
        for warning in found:
            if warning.kind not in self._told:
                self._told.add(warning.kind)
                # rclpy wants the two levels in two lines
                if warning.acts:
                    self._logger.warning(str(warning))
                else:
                    self._logger.info(str(warning))
        return ([warning.kind for warning in found if warning.acts],
                {f'warning: {warning.kind}': str(warning) for warning in found})

    def close(self, log):
        """Leave them in the log, with the numbers of the run's end."""
        step = self._driver.total_step
        for warning in self._driver.warnings():
            log.event(step, 'warning', kind=warning.kind, text=str(warning))
