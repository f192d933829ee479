"""What each figure of the register shows of a small result: labels, scales, and the variables along its axes.

Units are the names of the variables whose unit a label shows, # is a number, - what is computed for the figure.
`python -m tests.plots.test_register` writes it anew, and ruff formats it; read what has changed.
"""

TABLE = {
    "step": [
        (
            "x: time after the step (of time); y: displacement (of displacement); title: dashed: end of a slow "
            "ramp; dotted: settling time",
            [
                "solid displacement over time: # of constant_voltage",
                "dashed level at equilibrium_displacement",
                "dotted upright at settling_time",
                "solid level at initial_displacement",
                "solid in the legend: faint: the model does not hold",
            ],
        ),
        ("figure", ["# of constant_voltage, faint: the model does not hold"]),
    ],
    "creep": [
        (
            "y: displacement (of displacement); title: dashed: equilibrium; dotted: pull-in; log x",
            ["solid displacement over time", "dashed level at equilibrium_displacement"],
        ),
        ("x: constant voltage (of held_voltage); y: time to pull-in (of time)", ["text: no voltage pulls it in"]),
        (
            "x: holding time (of time); y: margin (% of the voltage); log x",
            ["solid margin in % over time: # of constant_voltage"],
        ),
        ("figure", ["# of constant_voltage"]),
    ],
    "transfer functions": [
        (
            "y: displacement over voltage (of gain); log x and y",
            [
                "solid gain over drive_frequency: linear theory",
                "points . measured_gain over drive_frequency: simulated, # of amplitude",
                "points o measured_gain over drive_frequency: simulated, # of amplitude",
                "dashed upright at natural_frequency",
                "ticks as 1.5",
            ],
        ),
        (
            "y: current over voltage (of admittance); log x and y",
            [
                "solid admittance over drive_frequency: linear theory",
                "points . measured_admittance over drive_frequency: simulated, # of amplitude",
                "points o measured_admittance over drive_frequency: simulated, # of amplitude",
                "dashed upright at natural_frequency",
                "ticks as 1.5",
            ],
        ),
        (
            "x: drive frequency (of drive_frequency); y: phase (degree); log x",
            [
                "solid phase over drive_frequency: linear theory",
                "points . measured_phase over drive_frequency: simulated, # of amplitude",
                "points o measured_phase over drive_frequency: simulated, # of amplitude",
                "dashed upright at natural_frequency",
                "ticks as 1.5",
            ],
        ),
        (
            "x: drive frequency (of drive_frequency); y: phase (degree); log x",
            [
                "solid admittance_phase over drive_frequency: linear theory",
                "points . measured_admittance_phase over drive_frequency: simulated, # of amplitude",
                "points o measured_admittance_phase over drive_frequency: simulated, # of amplitude",
                "dashed upright at natural_frequency",
                "ticks as 1.5",
            ],
        ),
        ("figure", ["linear theory, simulated, # of amplitude"]),
    ],
    "triptych": [
        (
            "x: time (of time); y: from the start displacement (of displacement); title: voltage # of voltage "
            "rest $\\lambda_1$ = # ± # per second",
            ["solid displacement over time"],
        ),
        (
            "x: time (of time); title: voltage # of voltage periodic, period # $\\lambda_1$ = # ± # per second",
            ["solid displacement over time"],
        ),
        ("x: time, settled (of late_time); y: settled displacement (of displacement)", ["solid 0 over late_time"]),
        ("x: time, settled (of late_time)", ["solid late_displacement over late_time"]),
        (
            "x: displacement (of late_displacement); y: phase portrait velocity (of velocity)",
            ["solid velocity over displacement", "solid 0 over 0", "points o 0 over 0"],
        ),
        (
            "x: displacement (of late_displacement)",
            ["solid velocity over displacement", "solid late_velocity over late_displacement"],
        ),
        ("x: displacement (of section_displacement); y: section velocity (of velocity)", ["points o 0 over 0"]),
        ("x: displacement (of section_displacement)", ["points o late_velocity over late_displacement"]),
        ("figure", []),
    ],
    "bifurcation diagram": [
        (
            "y: displacement / (b - a) once per forcing period",
            [
                "points o section over voltage",
                "points o in the legend",
                "points o in the legend: from #,#",
                "points v section over voltage",
                "points v in the legend",
                "points v in the legend: down",
                "points ^ section over voltage",
                "points ^ in the legend",
                "points ^ in the legend: up",
                "points o in the legend: pale: model does not hold",
            ],
        ),
        (
            "y: largest exponent (per second); title: changes of regime: #, vertical lines",
            [
                "solid level at 0",
                "solid o lyapunov over voltage",
                "solid v lyapunov over voltage",
                "solid ^ lyapunov over voltage",
            ],
        ),
        (
            "x: voltage (of voltage)",
            [
                "points . in the legend",
                "cells of regime",
                "cells of threshold_of_one_path",
                "filled - over voltage",
                "ticks: up, down, from #,#",
            ],
        ),
        ("figure", ["from #,#, down, up, pale: model does not hold", "regime: rest, periodic, chaotic"]),
    ],
    "draws": [
        (
            "x: drive frequency (of drive_frequency); y: recommended highest peak voltage (of recommended_peak); log x",
            ["solid - over drive_frequency: median", "filled - over drive_frequency: # % of the draws", "ticks as 1.5"],
        ),
        ("figure", ["# % of the draws, median"]),
    ],
    "extrema": [
        (
            "x: phase within the forcing period; y: displacement (of displacement); title: turning points",
            ["points displacement over phase: maxima", "points displacement over phase: minima"],
        ),
        ("figure", ["maxima, minima"]),
    ],
    "best drive": [
        (
            "y: peak voltage (of peak_voltage); log x",
            [
                "solid window_peak over frequency",
                "points * peak_voltage over drive_frequency: best drive, # of drive_frequency, # of peak_voltage",
                "points x limit_voltage over drive_frequency: limit: hoop slack",
                "filled window_peak over frequency: recommended window",
                "ticks as 1.5",
            ],
        ),
        (
            "x: drive frequency (of frequency); y: stroke at the window's edge (of window_value); log x",
            ["solid . window_value over frequency", "points * stroke over drive_frequency", "ticks as 1.5"],
        ),
        ("x: time (of time); y: displacement (of displacement)", ["solid displacement over time"]),
        ("y: voltage (of drive_voltage)", ["dashed drive_voltage over time"]),
        (
            "x: change of the stroke, % per %",
            [
                "solid upright at 0",
                "bars of sensitivity",
                "ticks: stretch limit, damping ratio, rest height, spring stiffness, drive frequency, "
                "prestretch, voltage",
            ],
        ),
        ("figure", ["recommended window, best drive, # of drive_frequency, # of peak_voltage, limit: hoop slack"]),
    ],
    "branches": [
        (
            "y: displacement once per forcing period (of lowest)",
            ["points . run_section over run_value", "solid orbit over value", "dashed nothing over value"],
        ),
        (
            "x: drive frequency (of value); y: largest exponent (per second)",
            ["solid level at 0", "solid lyapunov over value", "dashed nothing over value"],
        ),
        ("figure", ["stable, unstable, brute force, period #, the model holds nowhere here"]),
    ],
    "locus": [
        (
            "x: voltage (of voltage); y: drive frequency (of drive_frequency)",
            ["solid drive_frequency over voltage: period doubling, period #"],
        ),
        ("figure", ["period doubling, period #"]),
    ],
    "basins of attraction": [
        (
            "x: initial displacement (of displacement); y: initial velocity (of velocity)",
            ["points . in the legend", "cells of 0"],
        ),
        ("figure", ["rest: # % at # of attractor_lowest, the model holds nowhere here"]),
    ],
    "data sheet": [
        (
            "",
            [
                "solid level at -",
                "text: cone model, dimensionless",
                "text: data sheet, computed",
                "text: constant voltage",
                "text: # of constant_voltage",
                "text: blocked force",
                "text: # of blocked_force",
                "text: free stroke",
                "text: # of stroke",
                "text: stiffness under voltage",
                "text: # of stiffness_at_rest",
                "text: work of a stroke (out alone)",
                "text: # of stroke_work",
                "text: of it on a constant load",
                "text: # of load_work",
                "text: over film volume",
                "text: # of volume_work",
                "text: over moving mass",
                "text: # of mass_work",
                "text: power over film volume",
                "text: # of volume_power",
                "text: power over moving mass",
                "text: # of mass_power",
                "text: coupling factor, squared",
                "text: # of coupling",
                "text: capacitance",
                "text: # of capacitance",
                "text: energy of the field",
                "text: # of field_energy",
                "text: natural frequency",
                "text: # of natural_frequency",
                "text: half width at half power",
                "text: # of half_width",
                "text: bandwidth, to half power",
                "text: # of bandwidth",
                "text: rise time of a small step",
                "text: # of rise_time",
                "text: rest height",
                "text: # of rest_displacement",
                "text: stiffness at rest",
                "text: stroke of the drive",
                "text: # of drive_stroke",
                "text: peak current",
                "text: # of peak_current",
                "text: apparent power",
                "text: # of apparent_power",
                "text: mean power supplied",
                "text: # of mean_power",
                "text: pull-in of the membrane under constant voltage: unknown without radius_ratio",
                "text: pull-in of the cone under constant voltage: none",
                "text: first limit: hoop slack of the drive, at a peak of # of first_limit_voltage",
                "text: below every limit: peaks up to # of safe_peak_voltage",
                "text: dielectric strength: unknown, breakdown is not accounted for",
            ],
        ),
        (
            "x: height (of displacement); y: force on a load (of force); title: dot: blocked force, diamond: "
            "free stroke",
            [
                "solid - over displacement: # of constant_voltage",
                "points o 0 over rest_displacement",
                "points D 0 over rest_displacement",
                "points o blocked_force over rest_displacement",
                "points D 0 over equilibrium_displacement",
                "solid level at 0",
                "filled - over displacement",
            ],
        ),
        (
            "x: constant voltage (of ramp_voltage); y: free stroke (of ramp_stroke)",
            ["solid ramp_stroke over ramp_voltage"],
        ),
        (
            "x: frequency (of drive_frequency); y: small stroke over static one; log x and y",
            [
                "solid gain over drive_frequency: about # of constant_voltage",
                "dotted level at -: half power",
                "ticks as 1.5",
            ],
        ),
        (
            "x: peak voltage (of first_limit_voltage); title: limits met: peak of the drive",
            [
                "bars of -",
                "text: #",
                "ticks: stretch limit, meridional slack, drive: meridional slack, hoop slack, drive: hoop slack",
            ],
        ),
        ("y: blocked force (of ramp_blocked_force)", ["dashed ramp_blocked_force over ramp_voltage"]),
        ("figure", ["# of constant_voltage", "about # of constant_voltage, half power"]),
    ],
    "designs": [
        ("x: stroke (mm); y: apparent power (mVA)", ["solid o apparent_power over stroke", "text: #"]),
        (
            "x: design; y: share of devices that meet all",
            ["points o probability over design", "dashed level at -: required"],
        ),
        ("x: design; y: peak voltage (V)", ["bars of -", "bars of peak_voltage"]),
        ("figure", ["designs: quick", "required", "first limit, peak of the drive"]),
    ],
    "device fit": [
        (
            "x: height; title: blocked force, force.csv",
            ["points . measured over reading_along", "solid predicted over reading_along"],
        ),
        (
            "x: voltage; title: stroke over voltage, stroke.csv",
            ["points . measured over reading_along", "solid predicted over reading_along"],
        ),
        (
            "x: frequency (Hz); title: frequency response, response.csv",
            ["points . measured over reading_along", "solid predicted over reading_along"],
        ),
        (
            "y: measured over fitted; title: ring-down, test #",
            ["points . - over reading_test", "solid level at prior", "ticks: frequency # Hz, decay # #/s"],
        ),
        (
            "x: standard deviation left, over the prior",
            [
                "points . - over -",
                "solid upright at prior",
                "bars of -",
                "text: far from its prior",
                "ticks: spring_rate, damping_coefficient, gain of the load cell, gain of the laser, gain of the "
                "amplifier",
            ],
        ),
        (
            "figure",
            [
                "device fit: pump as drawn, taut film: refused by chi2, not to be relied on",
                "force",
                "stroke",
                "in phase, quadrature",
            ],
        ),
    ],
    "device plan": [
        (
            "x: standard deviation left, over the prior",
            [
                "points . - over -",
                "solid upright at prior",
                "bars of -",
                "ticks: spring_rate, damping_coefficient, gain of the load cell, gain of the laser, gain of "
                "the amplifier",
            ],
        ),
        ("figure", ["device plan: pump as drawn"]),
    ],
    "film": [
        (
            "x: radius (of ring_radius); y: height (of displacement)",
            [
                "solid nothing over nothing",
                "solid height over -",
                "solid constant_voltage over -",
                "solid ring_height over -",
                "solid ring_height over ring_radius",
                "solid in the legend: wrinkled",
            ],
        ),
        ("y: true field (of true_field)", ["cells of - in viridis"]),
        (
            "x: mounted radius (of mounted_radius); y: stretch (dashed: hoop)",
            [
                "solid meridional_stretch over mounted_radius: # of displacement, # of constant_voltage",
                "dashed hoop_stretch over mounted_radius",
            ],
        ),
        (
            "x: mounted radius (of mounted_radius); y: true field (of true_field)",
            ["solid true_field over mounted_radius"],
        ),
        (
            "x: height (of height); y: capacitance (of capacitance)",
            ["solid . capacitance over height: # of constant_voltage"],
        ),
        ("figure", ["wrinkled", "# of displacement, # of constant_voltage", "# of constant_voltage"]),
    ],
    "frequency response": [
        (
            "y: stroke, peak to peak (of stroke)",
            [
                "solid ^ stroke over drive_frequency",
                "solid ^ nothing over drive_frequency: swept up",
                "solid in the legend: faint: the model does not hold",
                "points o nothing over drive_frequency",
                "points D stroke over linear_peak_frequency: highest, up",
                "solid v stroke over drive_frequency",
                "solid v nothing over drive_frequency: swept down",
                "points D stroke over linear_peak_frequency: highest, down",
                "dashed linear_stroke over drive_frequency: linear theory",
            ],
        ),
        (
            "x: drive frequency (of drive_frequency); y: phase at # x the drive frequency (degrees)",
            ["solid harmonic_phase over drive_frequency", "dashed linear_phase over drive_frequency"],
        ),
        ("figure", ["swept up, faint: the model does not hold, highest, up, swept down, highest, down, linear theory"]),
    ],
    "cone and continuum": [
        (
            "x: displacement (of displacement); y: force on the disc, film and field (of cone_force)",
            [
                "solid level at 0",
                "solid cone_force over displacement: cone, voltage # of constant_voltage",
                "points o continuum_force over displacement",
                "points o nothing over displacement",
                "points X nothing over displacement",
                "points o in the legend: continuum, taut",
            ],
        ),
        (
            "x: radius (of radius); y: height (of height)",
            ["solid height over radius: displacement # of displacement", "dashed height over mounted_radius"],
        ),
        (
            "x: mounted radius (of mounted_radius); y: stretch",
            [
                "solid meridional_stretch over mounted_radius",
                "dotted hoop_stretch over mounted_radius",
                "dashed level at cone_stretch",
                "solid in the legend: meridional",
                "dotted in the legend: hoop",
                "dashed in the legend: meridional, cone",
            ],
        ),
        (
            "figure",
            [
                "cone, voltage # of constant_voltage, continuum, taut",
                "displacement # of displacement",
                "meridional, hoop, meridional, cone",
            ],
        ),
    ],
    "operating envelope": [
        (
            "x: drive frequency (of drive_frequency); y: peak voltage (of peak_voltage); log x",
            [
                "solid o in the legend: dielectric breakdown: unknown, no strength given",
                "solid s limit_low over drive_frequency: hoop slack, driven",
                "solid ^ limit_low over drive_frequency: meridional slack, driven",
                "dashed level at static_limit_voltage: hoop slack, quasi-static",
                "dash-dotted level at static_limit_voltage: meridional slack, quasi-static",
                "filled recommended_peak over drive_frequency: recommended window",
                "ticks as 1.5",
            ],
        ),
        ("y: static stroke (of stroke)", ["solid stroke over constant_voltage"]),
        ("y: blocked force (of blocked_force)", ["dashed blocked_force over constant_voltage"]),
        (
            "x: constant voltage (of constant_voltage); y: natural freq. (of natural_frequency)",
            ["solid natural_frequency over constant_voltage"],
        ),
        (
            "x: drive frequency (of drive_frequency); y: stroke (of window_stroke); title: at the window's edge; log x",
            ["solid window_stroke over drive_frequency", "ticks as 1.5"],
        ),
        (
            "y: mean power supplied (of window_power); log x",
            ["dashed window_damper_power over drive_frequency", "ticks as 1.5"],
        ),
        (
            "figure",
            [
                "recommended window, dielectric breakdown: unknown, no strength given, hoop slack, "
                "driven, meridional slack, driven, hoop slack, quasi-static, meridional slack, "
                "quasi-static"
            ],
        ),
    ],
    "instability tongues of rest": [
        (
            "x: drive frequency (of drive_frequency); y: voltage amplitude (of voltage)",
            [
                "solid . boundary_voltage over drive_frequency: onset",
                "dashed level at pitchfork_amplitude: static pitchfork at the peak",
            ],
        ),
        ("y: growth rate of deviations from rest (per second)", ["cells of - in YlOrBr"]),
        ("figure", ["grows with period #, onset, static pitchfork at the peak"]),
    ],
    "Lyapunov exponents": [
        (
            "x: window length (of running_time); y: largest Lyapunov exponent (per second); log x",
            [
                "solid level at 0",
                "dashed finite_exponent over finite_time",
                "points o finite over finite_time",
                "solid running_exponent over running_time: # ± # certainly negative",
                "solid lyapunov over running_time",
                "dashed o in the legend: from the start, to the end of the finite window",
                "solid in the legend: after the transient, with long-run value ± s.e.",
                "filled - over running_time",
            ],
        ),
        (
            "figure",
            [
                "# ± # certainly negative, from the start, to the end of the finite window, after the "
                "transient, with long-run value ± s.e."
            ],
        ),
    ],
    "material fit": [
        (
            "x: stretch; y: stress (kPa); title: vhb-quasi-static #: # %",
            [
                "points . stress over stretch: measured",
                "solid predicted over stretch: material",
                "dashed left_out over stretch: predicted from the other tests",
                "solid level at 0",
                "filled - over stretch: # % band of a prediction",
            ],
        ),
        (
            "x: time (h); title: vhb-relaxation #: # %",
            [
                "points . stress over -: measured",
                "solid predicted over -: material",
                "dashed left_out over -: predicted from the other tests",
                "solid level at 0",
                "filled - over -: # % band of a prediction",
            ],
        ),
        (
            "x: time (h); title: vhb-relaxation #: # %",
            [
                "points . stress over -: measured",
                "solid predicted over -: material",
                "dashed left_out over -: predicted from the other tests",
                "solid level at 0",
                "filled - over -: # % band of a prediction",
            ],
        ),
        (
            "x: time (h); title: vhb-relaxation #: # %",
            [
                "points . stress over -: measured",
                "solid predicted over -: material",
                "dashed left_out over -: predicted from the other tests",
                "solid level at 0",
                "filled - over -: # % band of a prediction",
            ],
        ),
        (
            "x: time (h); y: stress (kPa); title: vhb-relaxation #: # %",
            [
                "points . stress over -: measured",
                "solid predicted over -: material",
                "dashed left_out over -: predicted from the other tests",
                "solid level at 0",
                "filled - over -: # % band of a prediction",
            ],
        ),
        (
            "figure",
            [
                "material fit: fitted material, gent with # branches",
                "measured, material, predicted from the other tests, # % band of a prediction",
            ],
        ),
    ],
    "parameter map": [
        (
            "x: voltage (of voltage); y: prestretch (of prestretch); title: largest exponent (per second)",
            ["points . in the legend", "cells of lyapunov"],
        ),
        ("x: voltage (of voltage); title: regime", ["points . in the legend", "cells of period"]),
        ("", ["cells of -", "ticks as "]),
        ("figure", ["rest, periodic, the model holds nowhere here"]),
    ],
    "Poincare section": [
        (
            "x: displacement (of displacement); y: velocity (of velocity); title: Poincaré section: "
            "once every forcing period",
            ["points velocity over displacement"],
        ),
        ("figure", []),
    ],
    "regime of motion": [
        (
            "x: displacement / (b - a); y: velocity / ((b - a) $\\Omega_0$); title: Poincaré section: "
            "once every forcing period",
            [
                "points section over section: periodic, period # largest exponent # ± # per second "
                "settled (within # of its size)"
            ],
        ),
        ("figure", ["periodic, period # largest exponent # ± # per second settled (within # of its size)"]),
    ],
    "spectrum": [
        (
            "x: frequency (of frequency); y: amplitude (of amplitude); title: # % of the variance in lines, "
            "flatness #; log y",
            ["solid amplitude over frequency", "points o line_amplitude over line_frequency", "text: #"],
        ),
        ("figure", []),
    ],
    "statics": [
        (
            "x: displacement (of displacement); y: force that holds the disc (of force)",
            [
                "solid level at 0",
                "solid force over displacement",
                "dashed nothing over displacement",
                "solid in the legend: voltage # of constant_voltage",
                "points o 0 over rest_displacement",
                "points o in the legend",
                "points o 0 over equilibrium_displacement",
                "points x 0 over equilibrium_displacement",
                "points x in the legend: model does not hold",
            ],
        ),
        (
            "x: constant voltage (of branch_voltage); y: displacement (of branch_displacement)",
            [
                "solid branch_displacement over branch_voltage",
                "dashed branch_displacement over branch_voltage",
                "dashed nothing over branch_voltage",
                "solid in the legend: stable",
                "dashed in the legend: unstable",
                "points D fold_displacement over fold_voltage: fold",
                "solid in the legend: faint: the model does not hold",
            ],
        ),
        (
            "figure",
            [
                "voltage # of constant_voltage, model does not hold",
                "stable, unstable, fold, faint: the model does not hold",
            ],
        ),
    ],
    "sweep": [
        ("y: per repeat (of per_repeat)", ["solid . per_repeat over voltage"]),
        ("y: averaged time (of averaged_time)", ["solid . averaged_time over voltage"]),
        ("y: cycle (of cycle)", ["solid . cycle over voltage"]),
        ("y: sign (of sign)", ["solid . sign over voltage"]),
        ("x: voltage (of voltage); y: sum residual (of sum_residual)", ["solid . 0 over voltage"]),
        ("figure", []),
    ],
    "probability": [
        (
            "x: voltage (of voltage); y: probability that the motion is chaotic",
            ["solid o 0 over voltage: share of the draws", "filled high over voltage: interval"],
        ),
        ("figure", ["interval, share of the draws"]),
    ],
    "time response": [
        ("y: displacement (of displacement)", ["solid displacement over time"]),
        ("x: time (of time); y: voltage (of drive_voltage)", ["solid drive_voltage over time"]),
        ("", ["filled - over -", "text: film slack", "text: #%"]),
        ("x: displacement (of displacement); y: velocity (of velocity)", ["solid velocity over displacement"]),
        ("figure", []),
    ],
    "map of the stroke": [
        (
            "x: voltage (of voltage); y: prestretch (of prestretch); title: stroke, peak to peak (of highest)",
            ["points . in the legend", "cells of - in viridis"],
        ),
        ("x: voltage (of voltage); title: regime", ["points . in the legend", "cells of period"]),
        ("", ["cells of - in viridis"]),
        ("figure", ["rest, periodic, the model holds nowhere here"]),
    ],
    "diagram of the extent": [
        (
            "y: displacement / (b - a) once per forcing period",
            [
                "points o section over voltage",
                "points o in the legend",
                "points o in the legend: from #,#",
                "points v section over voltage",
                "points v in the legend",
                "points v in the legend: down",
                "points ^ section over voltage",
                "points ^ in the legend",
                "points ^ in the legend: up",
                "points o in the legend: pale: model does not hold",
            ],
        ),
        (
            "y: lowest and highest displacement (of lowest); title: changes of regime: #, vertical lines",
            [
                "solid o lowest over voltage",
                "solid o highest over voltage",
                "solid v lowest over voltage",
                "solid v highest over voltage",
                "solid ^ lowest over voltage",
                "solid ^ highest over voltage",
            ],
        ),
        (
            "x: voltage (of voltage)",
            [
                "points . in the legend",
                "cells of regime",
                "cells of threshold_of_one_path",
                "filled - over voltage",
                "ticks: up, down, from #,#",
            ],
        ),
        ("figure", ["from #,#, down, up, pale: model does not hold", "regime: rest, periodic, chaotic"]),
    ],
    "ensemble of responses": [
        ("title: voltage # of voltage (at times film slack)", ["solid displacement over time"]),
        ("", ["solid velocity over displacement"]),
        (
            "x: time (of time); y: displacement (of displacement); title: voltage # of voltage (at times film slack)",
            ["solid displacement over time"],
        ),
        ("x: displacement (of displacement); y: velocity (of velocity)", ["solid velocity over displacement"]),
        ("figure", []),
    ],
    "response of two films": [
        ("y: displacement (of displacement)", ["solid displacement over time"]),
        (
            "x: time (of time); y: voltage (of drive_voltage)",
            ["solid drive_voltage over time", "dashed drive_voltage over time"],
        ),
        ("", ["filled - over -", "text: film slack", "text: #%"]),
        ("x: displacement (of displacement); y: velocity (of velocity)", ["solid velocity over displacement"]),
        ("figure", []),
    ],
    "ensemble of exponents": [
        (
            "x: window length (of running_time); y: largest Lyapunov exponent (per second); log x",
            [
                "solid level at 0",
                "dashed finite_exponent over finite_time",
                "points o finite over finite_time",
                "solid running_exponent over running_time: voltage # of voltage # ± # certainly negative",
                "solid lyapunov over running_time",
                "dashed o in the legend: from the start, to the end of the finite window",
                "solid in the legend: after the transient, with long-run value ± s.e.",
                "filled - over running_time",
            ],
        ),
        (
            "figure",
            [
                "voltage # of voltage # ± # certainly negative, from the start, to the end of the "
                "finite window, after the transient, with long-run value ± s.e."
            ],
        ),
    ],
    "limits over two": [
        (
            "x: spring stiffness (of spring_stiffness); y: prestretch (of prestretch); title: onset "
            "voltage (of onset_voltage)",
            ["cells of onset_voltage in viridis"],
        ),
        (
            "x: spring stiffness (of spring_stiffness); y: prestretch (of prestretch); title: onset "
            "error (of onset_error)",
            ["cells of onset_error in viridis"],
        ),
        (
            "x: spring stiffness (of spring_stiffness); y: prestretch (of prestretch); title: pitchfork "
            "voltage (of pitchfork_voltage)",
            ["cells of pitchfork_voltage in viridis"],
        ),
        ("", ["cells of - in viridis"]),
        ("", ["cells of - in viridis"]),
        ("", ["cells of - in viridis"]),
        ("figure", []),
    ],
    "limits of draws": [
        ("x: onset voltage (of onset_voltage)", ["points | 0 over onset_voltage", "solid - over -", "filled - over -"]),
        ("x: onset error (of onset_error)", ["points | 0 over onset_error", "solid - over -", "filled - over -"]),
        (
            "x: pitchfork voltage (of pitchfork_voltage)",
            ["points | 0 over pitchfork_voltage", "solid - over -", "filled - over -"],
        ),
        ("figure", []),
    ],
    "limits over one and draws": [
        ("y: onset voltage (of onset_voltage)", ["points . onset_voltage over spring_stiffness"]),
        ("y: onset error (of onset_error)", ["points . onset_error over spring_stiffness"]),
        (
            "x: spring stiffness (of spring_stiffness); y: pitchfork voltage (of pitchfork_voltage)",
            ["points . pitchfork_voltage over spring_stiffness"],
        ),
        ("figure", []),
    ],
    "tolerances over one": [
        (
            "y: stroke (of highest)",
            ["solid o - over voltage: median", "filled - over voltage: from # to # % of the draws"],
        ),
        (
            "x: voltage (of voltage); y: probability",
            ["solid o 0 over voltage: pull-in", "solid o 0 over voltage: chaos", "filled - over voltage"],
        ),
        ("figure", ["from # to # % of the draws, median", "pull-in, chaos"]),
    ],
    "tolerances": [
        (
            "x: stroke (of highest); title: motions; at rest # %, without a long run # %; quantiles #, #, # %",
            ["points | 0 over -", "solid - over -", "solid upright at -", "filled - over -"],
        ),
        (
            "title: probability, with its # % interval",
            [
                "points | source over 0",
                "points | source over -",
                "bars of 0",
                "ticks: pull-in, breakdown: not known, chaos",
            ],
        ),
        ("figure", []),
    ],
    "probability over two": [
        (
            "x: voltage (of voltage); y: prestretch (of prestretch); title: probability that the motion is chaotic",
            ["cells of probability in cividis"],
        ),
        ("x: voltage (of voltage); title: width of the interval", ["cells of - in Greys"]),
        ("", ["cells of - in cividis"]),
        ("", ["cells of - in Greys"]),
        ("figure", []),
    ],
    "response with branches": [
        (
            "y: stroke, peak to peak (of stroke)",
            [
                "points . stroke over drive_frequency",
                "solid - over followed_value",
                "dashed nothing over followed_value",
                "dashed linear_stroke over drive_frequency: linear theory",
            ],
        ),
        (
            "x: drive frequency (of drive_frequency); y: phase at # x the drive frequency (degrees)",
            [
                "solid harmonic_phase over drive_frequency: phase, swept up",
                "dotted harmonic_phase over drive_frequency: phase, swept down",
                "dashed linear_phase over drive_frequency",
            ],
        ),
        (
            "figure",
            [
                "stable, unstable, brute force, period #, the model holds nowhere here, linear "
                "theory, phase, swept up, phase, swept down"
            ],
        ),
    ],
    "static forces": [
        ("y: displacement (of displacement)", ["solid . displacement over constant_voltage"]),
        ("y: stroke (of stroke)", ["solid . stroke over constant_voltage"]),
        ("y: blocked force (of blocked_force)", ["solid . blocked_force over constant_voltage"]),
        (
            "x: constant voltage (of constant_voltage); y: cycle work (of cycle_work)",
            ["solid . cycle_work over constant_voltage"],
        ),
        ("figure", ["stroke and blocked force"]),
    ],
}
