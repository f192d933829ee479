"""The physics: what there is, and the equation of motion that follows from its energy."""
