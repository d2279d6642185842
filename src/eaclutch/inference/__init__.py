"""Priors, likelihoods, sampling, convergence and storage of posteriors."""
