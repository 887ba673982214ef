"""What `snowmpm check` advises: corners of the atlas that a scene sits in, and what it could do without."""
