"""What figures of the paper show: labels, scales, legends, and the variables along their axes.

Of the figures with motions at three values of a parameter the one with most kinds of motion stands for all. # is a
number, - what is computed for the figure. `python -m tests.paper.test_figures` writes it anew, and ruff formats it;
read what has changed.
"""

TABLE = {
    3: [
        (
            "x: displacement $x$; y: static force on the disc",
            [
                "solid level at 0",
                "solid static.force over static.displacement",
                "dashed nothing over static.displacement",
                "solid in the legend: $v$ = #",
                "points o 0 over 0",
                "points o in the legend",
                "solid nothing over static.displacement",
                "dashed static.force over static.displacement",
                "points o 0 over static.equilibrium_displacement",
                "points o in the legend: stable equilibrium",
                "points o in the legend: unstable equilibrium",
                "dashed in the legend: film slack: the model does not hold",
                "points s - over continuum.displacement",
                "points s - over -",
                "points s nothing over continuum.displacement",
                "points s nothing over -",
                "points s in the legend: continuum in tension",
                "points s in the legend: continuum, compressed",
            ],
        ),
        (
            "x: constant voltage $v$; y: equilibrium displacement",
            [
                "solid static.branch_displacement over static.branch_voltage: stable",
                "dashed 0 over static.branch_voltage: unstable",
                "solid upright at 0",
                "solid upright at continuum.constant_voltage",
                "solid upright at continuum.spring_stiffness",
                "text: pitchfork at $v$ = #",
            ],
        ),
        (
            "figure",
            [
                "set table1: $\\kappa$ = #, $J$ = #, $\\lambda_p$ = #",
                "stable, unstable",
                "$v$ = #, stable equilibrium, unstable equilibrium, film slack: the model does not hold, "
                "continuum in tension, continuum, compressed",
            ],
        ),
    ],
    5: [
        (
            "x: time from the start; y: displacement; title: $J$ = #",
            [
                "solid displacement over time",
                "text: window: $\\lambda_1 = #$ long run: chaotic, $\\lambda_1 = # \\pm #$",
                "text: slack # %",
            ],
        ),
        (
            "x: time from the start; title: $J$ = #",
            [
                "solid displacement over time",
                "text: window: $\\lambda_1 = #$ long run: periodic, period #, $\\lambda_1 = # \\pm{}<#$",
                "text: slack # %",
            ],
        ),
        (
            "x: time from the start; title: $J$ = #",
            [
                "solid displacement over time",
                "text: window: $\\lambda_1 = #$ long run: periodic, period #, $\\lambda_1 = # \\pm{}<#$",
                "text: slack # %",
            ],
        ),
        ("x: after the transient; y: displacement", ["solid late_displacement over late_time", "text: slack # %"]),
        ("x: after the transient", ["solid late_displacement over late_time", "text: slack # %"]),
        ("x: after the transient", ["solid late_displacement over late_time", "text: slack # %"]),
        (
            "x: displacement; y: phase portrait velocity",
            ["solid velocity over displacement", "solid late_velocity over late_displacement"],
        ),
        ("x: displacement", ["solid velocity over displacement", "solid late_velocity over late_displacement"]),
        ("x: displacement", ["solid velocity over displacement", "solid late_velocity over late_displacement"]),
        (
            "x: displacement; y: Poincaré section velocity",
            [
                "points x early_section_velocity over early_section_displacement",
                "points o section_velocity over section_displacement",
            ],
        ),
        (
            "x: displacement",
            [
                "points x early_section_velocity over early_section_displacement",
                "points o section_velocity over section_displacement",
            ],
        ),
        (
            "x: displacement",
            [
                "points x early_section_velocity over early_section_displacement",
                "points o section_velocity over section_displacement",
            ],
        ),
        (
            "figure",
            [
                "set fast: $\\zeta$ = #, $v$ = #, $\\lambda_p$ = #, $\\kappa$ = #, $\\omega$ = #, $x_0$ = #",
                "film taut, film slack: the model does not hold, window from the start, long run: chaotic, long "
                "run: periodic",
            ],
        ),
    ],
    6: [
        (
            "x: displacement $x$; y: strain energy of the film",
            [
                "solid film_energy over displacement: $J$ = #",
                "dotted upright at displacement",
                "dotted upright at reach",
                "dotted upright at -",
            ],
        ),
        (
            "x: displacement $x$; y: velocity; title: $J$ = #",
            [
                "points o 0 over surface_limit",
                "solid o in the legend: free motion without damping from the start",
                "text: beyond the stretch limit",
            ],
        ),
        (
            "x: displacement $x$; title: $J$ = #",
            ["points o 0 over surface_limit", "solid o in the legend: free motion without damping from the start"],
        ),
        ("y: energy without voltage", ["cells of - in cividis"]),
        ("figure", ["set fast: $\\kappa$ = #, $\\lambda_p$ = #", "dotted: where the film would reach $J$: $J$ = #"]),
    ],
    8: [
        (
            "y: amplitude; title: set base, $v$ = #; title: long run: rest; log y",
            [
                "dotted upright at fate",
                "dashed upright at fate",
                "solid early_amplitude over early_frequency_ratio",
                "solid 0 over early_frequency_ratio",
                "text: no motion is left",
            ],
        ),
        (
            "title: set fast, $v$ = #; title: long run: rest; log y",
            [
                "dotted upright at fate",
                "dashed upright at fate",
                "solid early_amplitude over early_frequency_ratio",
                "solid 0 over early_frequency_ratio",
                "text: no motion is left",
            ],
        ),
        (
            "y: amplitude; title: set base, $v$ = #; title: long run: chaotic; log y",
            [
                "dotted upright at fate",
                "dashed upright at fate",
                "solid early_amplitude over early_frequency_ratio",
                "solid amplitude over early_frequency_ratio",
            ],
        ),
        (
            "title: set fast, $v$ = #; title: long run: periodic, period #; log y",
            [
                "dotted upright at fate",
                "dashed upright at fate",
                "solid early_amplitude over early_frequency_ratio",
                "solid amplitude over early_frequency_ratio",
            ],
        ),
        (
            "x: frequency / frequency of the voltage; y: amplitude; title: set base, $v$ = #; title: long "
            "run: chaotic; log y",
            [
                "dotted upright at fate",
                "dashed upright at fate",
                "solid early_amplitude over early_frequency_ratio",
                "solid amplitude over early_frequency_ratio",
            ],
        ),
        (
            "x: frequency / frequency of the voltage; title: set fast, $v$ = #; title: long run: periodic, "
            "period #; log y",
            [
                "dotted upright at fate",
                "dashed upright at fate",
                "solid early_amplitude over early_frequency_ratio",
                "solid amplitude over early_frequency_ratio",
            ],
        ),
        (
            "figure",
            ["from the start, long run (coloured by its kind), frequency of the voltage, frequency of its force"],
        ),
    ],
    9: [
        (
            "x: voltage amplitude (V); y: amplitude (mm); log x and y",
            [
                "points o window_amplitude over voltage_amplitude",
                "points o nothing over voltage_amplitude",
                "points v - over voltage_amplitude",
                "points s window_amplitude over voltage_amplitude",
                "points s late_amplitude over voltage_amplitude",
                "dashed upright at onset_voltage: rest is lost under the drive",
                "dotted upright at pitchfork_voltage: rest is lost statically",
            ],
        ),
        (
            "y: displacement (mm); title: # V",
            ["solid displacement over -", "dotted level at 0", "dotted level at rest_displacement"],
        ),
        (
            "y: displacement (mm); title: # V",
            ["solid displacement over -", "dotted level at 0", "dotted level at rest_displacement"],
        ),
        (
            "x: time from the release (s); y: displacement (mm); title: # V",
            ["solid displacement over -", "dotted level at 0", "dotted level at rest_displacement"],
        ),
        (
            "figure",
            [
                "paper's Table #, PVC-DBA #:#",
                "initial height # mm, filled: from the start, open: long run, long run: at rest, rest is lost "
                "under the drive, rest is lost statically",
            ],
        ),
    ],
    12: [
        (
            "x: drive frequency $\\omega$; y: amplitude; log x and y",
            [
                "solid frequency.amplitude over frequency.swept_frequency",
                "dashed frequency.amplitude over frequency.swept_frequency",
                "points o frequency.peak_amplitude over frequency.peak_frequency",
                "dashed frequency.branch_amplitude over frequency.branch_frequency",
                "dashed nothing over frequency.branch_frequency",
                "dashed in the legend: unstable orbits, up to period #",
                "solid in the legend: swept up",
                "dashed in the legend: swept down",
                "points o in the legend: highest point",
                "text: $\\kappa$ = #",
                "ticks as 1.5",
            ],
        ),
        (
            "y: at frequency; title: highest point; log x and y",
            [
                "solid frequency.swept_frequency over frequency.spring_stiffness: half the natural frequency",
                "points frequency.peak_frequency over frequency.spring_stiffness: swept up",
                "points frequency.peak_frequency over frequency.spring_stiffness: swept down",
                "ticks as 1.5",
            ],
        ),
        (
            "x: spring stiffness $\\kappa$; y: of amplitude; log x and y",
            [
                "points frequency.peak_amplitude over frequency.spring_stiffness: swept up",
                "points frequency.peak_amplitude over frequency.spring_stiffness: swept down",
                "ticks as 1.5",
            ],
        ),
        (
            "x: time from the start; y: displacement; title: $\\omega$ = #",
            ["solid frequency-responses.displacement over frequency-responses.time", "text: slack # %"],
        ),
        (
            "x: time from the start; title: $\\omega$ = #",
            ["solid frequency-responses.displacement over frequency-responses.time", "text: slack # %"],
        ),
        (
            "x: time from the start; title: $\\omega$ = #",
            ["solid frequency-responses.displacement over frequency-responses.time", "text: slack # %"],
        ),
        (
            "x: time after the transient; y: displacement",
            ["solid frequency-responses.late_displacement over frequency-responses.late_time", "text: slack # %"],
        ),
        (
            "x: time after the transient",
            ["solid frequency-responses.late_displacement over frequency-responses.late_time", "text: slack # %"],
        ),
        (
            "x: time after the transient",
            ["solid frequency-responses.late_displacement over frequency-responses.late_time", "text: slack # %"],
        ),
        (
            "figure",
            [
                "set spring: $\\zeta$ = #, $v$ = #, $J$ = #, $\\lambda_p$ = #, $x_0$ = #",
                "unstable orbits, up to period #, swept up, swept down, highest point",
                "swept up, swept down, half the natural frequency",
            ],
        ),
    ],
}
