"""The four stages' likelihoods: contact, dielectric, load cell, force; each module makes a Problem."""
