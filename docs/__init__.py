"""The guides of snowmpm, as Markdown."""
