"""The cheapest model that answers a question about a scene: a ladder of models, and what each was measured to miss."""
