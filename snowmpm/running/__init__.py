"""A simulation while it runs: the loop, events, audit, record, failures, the end."""
