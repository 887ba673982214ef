"""Problems whose answer is known, as studies and tests solve them."""
