"""The register of analyses, how the model to analyse is described in text, and how answers are put into words."""
