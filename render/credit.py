"""Whose data a picture shows."""


def attribution(record):
    """Credits found in a provenance record: every value of a key `attribution`, at any depth."""
    found = []
    if isinstance(record, dict):
        for key, value in record.items():
            found += [str(value)] if key == "attribution" else [attribution(value)]
    elif isinstance(record, list):
        found = [attribution(value) for value in record]
    return "; ".join(dict.fromkeys(text for text in found if text))
