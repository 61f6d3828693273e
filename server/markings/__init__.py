"""Markings of victims and worksites as they are sprayed: INSARAG and FEMA."""
