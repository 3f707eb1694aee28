"""The paper's findings, run again."""
