"""The verb `report`: error against run time, stability, cost of features; one page."""
