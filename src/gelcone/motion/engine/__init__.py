"""A Taylor integrator for any system of gelcone's components, compiled once and run over many members.

`gelcone.physics.trace` runs a system's formulas on graph nodes, `recurrences` turns the graph
into code for Taylor coefficients, `loop` puts that into a compiled loop over lanes (with `plan`, `step` and `service`),
`events` finds where a border is crossed, `compile` makes and keeps the object code, and `program` is what the rest of
the package calls.

A lane holds one member and depends on nothing but that member: its numbers have the same bits whatever its neighbours,
the number of threads, the lane width, the processor's instruction set and the operating system.

Nothing is loaded by importing this package: import `gelcone.motion.engine.program` where a program is needed.
"""
