"""What a step is, whatever the method: contract, length, report, contact velocity, settling to rest."""
