"""A Taylor integrator for any system of gelcone's components, compiled once and run over many members.

`gelcone.physics.trace` runs a system's formulas on graph nodes, `recurrences` and `jet` turn the graph into code for
Taylor coefficients (`equations` and `jet` those of roots), `loop` puts that into a compiled loop over lanes (with
`plan`, `step` and `service`), `events` finds crossings of borders, `compile` makes and keeps the object code, and the
rest of the package calls `program`.

A lane holds one member, whose numbers have the same bits whatever the neighbours, the number of threads, the lane
width, the processor's instruction set and the operating system.

Importing this package loads nothing: import `gelcone.motion.engine.program` for a program.
"""
