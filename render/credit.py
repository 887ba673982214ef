"""Whose data a picture shows."""


from snowmpm.errors import shown_line

LONGEST = 300


def attribution(record):
    """Credits found in a provenance record: every value of a key `attribution`, at any depth."""
    return shown_line(_credits(record), LONGEST)


def _credits(record):
    found = []
    if isinstance(record, dict):
        for key, value in record.items():
            found += [str(value)] if key == "attribution" else [_credits(value)]
    elif isinstance(record, list):
        found = [_credits(value) for value in record]
    return "; ".join(dict.fromkeys(text for text in found if text))
