"""A loss of strength that follows a strain averaged over a length."""
