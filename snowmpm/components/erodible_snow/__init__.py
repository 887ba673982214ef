"""Snow cover of a law of its own, laid as particles where a flow comes."""
