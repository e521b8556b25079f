"""The table of targets: every row measured now, written into the documents. `python -m tools.targets`."""
